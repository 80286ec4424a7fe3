//! Pictures: each one that a base colour needs is decoded once, all of them in parallel.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use antumbra::scene::Texture;
use image::{DynamicImage, ImageReader, Limits};

use super::materials::ImageUse;
use super::source::{Source, label};
use crate::Error;

/// Longest side of an image, the limit of most hardware. An image has at most its square of pixels.
const MAX_SIDE: u32 = 16384;

/// Bytes a pixel that decoding may take beside the result (16 bits a channel).
const DECODING_BYTES: u64 = 8;

/// An encoded image.
struct Job<'s> {
    image: usize,
    label: String,
    bytes: Cow<'s, [u8]>,
    width: u32,
    height: u32,
}

/// The textures of the scene, one for each use.
pub(super) fn decode(source: &Source<'_>, uses: &[ImageUse]) -> Result<Vec<Texture>, Error> {
    let mut jobs: BTreeMap<usize, Job<'_>> = BTreeMap::new();
    for one in uses {
        let job = match jobs.entry(one.image) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(prepare(source, one.image)?),
        };
        source.charge(u64::from(job.width) * u64::from(job.height), 4, &job.label)?;
    }
    let jobs: Vec<Job<'_>> = jobs.into_values().collect();
    let mut pixels = BTreeMap::new();
    for (job, result) in jobs.iter().zip(run(source, &jobs)?) {
        pixels.insert(job.image, result.map_err(|e| source.error(format!("{}: {e}", job.label)))?);
    }
    jobs.iter().for_each(|job| source.release(job.bytes.len() as u64));
    let mut left: BTreeMap<usize, usize> = BTreeMap::new();
    uses.iter().for_each(|u| *left.entry(u.image).or_default() += 1);
    let mut textures = Vec::new();
    for one in uses {
        // The last use takes the pixels, those before it copy them.
        let count = left.entry(one.image).or_default();
        *count = count.saturating_sub(1);
        let taken = if *count == 0 { pixels.remove(&one.image) } else { pixels.get(&one.image).cloned() };
        let (width, height, pixels) = taken.unwrap_or_default();
        let name = source.root.images[one.image].name.clone().unwrap_or_default();
        textures.push(Texture { name, width, height, pixels, wrap: one.wrap });
    }
    Ok(textures)
}

type Pixels = (u32, u32, Vec<[u8; 4]>);

/// Decodes with all cores. Pictures that are large together are decoded one after the other, to bound the memory.
fn run(source: &Source<'_>, jobs: &[Job<'_>]) -> Result<Vec<Result<Pixels, String>>, Error> {
    let size = |job: &Job<'_>| u64::from(job.width) * u64::from(job.height);
    let largest = jobs.iter().map(size).max().unwrap_or(0);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let small = largest <= 1 << 24;
    let threads = if small { cores.min(8).min(jobs.len()) } else { 1 };
    source.charge(largest * threads as u64, DECODING_BYTES as usize, "decoding images")?;
    let results: Vec<Mutex<Option<Result<Pixels, String>>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(job) = jobs.get(index) else { break };
                let result = decode_one(job);
                if let Ok(mut slot) = results[index].lock() {
                    *slot = Some(result);
                }
            }
        };
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    source.release(largest * threads as u64 * DECODING_BYTES);
    let finished = results
        .into_iter()
        .map(|slot| slot.into_inner().ok().flatten().unwrap_or_else(|| Err("was not decoded".into())));
    Ok(finished.collect())
}

/// Finds the bytes of an image and its size.
fn prepare<'s>(source: &'s Source<'_>, index: usize) -> Result<Job<'s>, Error> {
    let image = &source.root.images[index];
    let label = label(
        "image",
        index,
        image.name.as_deref().or(image.uri.as_deref().filter(|u| !u.starts_with("data:"))),
    );
    let bytes = match (&image.buffer_view, &image.uri) {
        (Some(view), _) => {
            // Nothing is copied, but each of many images could be the same long and slow stream of bytes.
            let bytes = source.view(view.value(), &label)?;
            source.charge(bytes.len() as u64, 1, &label)?;
            Cow::Borrowed(bytes)
        }
        (None, Some(uri)) => Cow::Owned(source.fetch(uri, &label)?),
        (None, None) => return Err(source.error(format!("{label} has neither a buffer view nor a URI"))),
    };
    let size = guarded(|| Ok(reader(&bytes)?.into_dimensions()?));
    let (width, height) = size.map_err(|e| source.error(format!("{label}: {e}")))?;
    if width > MAX_SIDE || height > MAX_SIDE {
        let what = format!(
            "{label} has {width} x {height} pixels; {MAX_SIDE} a side are supported: make it smaller"
        );
        return Err(source.error(what));
    }
    Ok(Job { image: index, label, bytes, width, height })
}

fn decode_one(job: &Job<'_>) -> Result<Pixels, String> {
    let image: DynamicImage = guarded(|| Ok(reader(&job.bytes)?.decode()?))?;
    let image = image.into_rgba8();
    let (width, height) = image.dimensions();
    if (width, height) != (job.width, job.height) {
        return Err("its size is not what its header says".into());
    }
    let flat = image.into_raw();
    let pixels =
        bytemuck::allocation::try_cast_vec(flat).unwrap_or_else(|(_, flat)| flat.as_chunks::<4>().0.to_vec());
    Ok((width, height, pixels))
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, Box<dyn std::error::Error>> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    if reader.format().is_none() {
        return Err("neither PNG nor JPEG: convert it to one of them".into());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(u64::from(MAX_SIDE) * u64::from(MAX_SIDE) * DECODING_BYTES);
    reader.limits(limits);
    Ok(reader)
}

/// Decoders are other people's code and get untrusted bytes: should one panic, this is an error too.
fn guarded<T>(decode: impl FnOnce() -> Result<T, Box<dyn std::error::Error>>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(result) => result.map_err(|e| e.to_string()),
        Err(_) => Err("the decoder failed".into()),
    }
}
