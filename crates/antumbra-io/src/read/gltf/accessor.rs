//! Typed arrays out of buffers. Every range is checked before the first byte is read.

use std::fmt::Display;

use gltf::json::accessor::{ComponentType, Type, sparse};

use super::source::{Source, label};
use crate::Error;

/// How an accessor's bytes become numbers.
#[derive(Clone, Copy)]
struct Element {
    component: ComponentType,
    /// Numbers an element.
    width: usize,
}

impl Element {
    fn size(self) -> usize {
        self.component.size() * self.width
    }
}

impl Source<'_> {
    /// Elements of `N` floats. Integers become floats, divided by their largest value if the accessor says so.
    pub(super) fn floats<const N: usize>(&self, index: usize, user: &str) -> Result<Vec<[f32; N]>, Error> {
        Ok(group(self.scalars(index, &[N], user)?.values))
    }

    /// All numbers of an accessor in one list. `widths` are the numbers an element may have.
    pub(super) fn scalars(&self, index: usize, widths: &[usize], user: &str) -> Result<Scalars, Error> {
        let (element, count) = self.describe(index, widths, user)?;
        let normalized = self.root.accessors[index].normalized;
        let n = element.width;
        let values = match (element.component, normalized) {
            (ComponentType::F32, _) => self.numbers(index, element, count, f32::from_le_bytes)?,
            (ComponentType::I8, true) => {
                self.numbers(index, element, count, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0))?
            }
            (ComponentType::U8, true) => {
                self.numbers(index, element, count, |b| f32::from(u8::from_le_bytes(b)) / 255.0)?
            }
            (ComponentType::I16, true) => self
                .numbers(index, element, count, |b| (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0))?,
            (ComponentType::U16, true) => {
                self.numbers(index, element, count, |b| f32::from(u16::from_le_bytes(b)) / 65535.0)?
            }
            (ComponentType::I8, false) => {
                self.numbers(index, element, count, |b| f32::from(i8::from_le_bytes(b)))?
            }
            (ComponentType::U8, false) => {
                self.numbers(index, element, count, |b| f32::from(u8::from_le_bytes(b)))?
            }
            (ComponentType::I16, false) => {
                self.numbers(index, element, count, |b| f32::from(i16::from_le_bytes(b)))?
            }
            (ComponentType::U16, false) => {
                self.numbers(index, element, count, |b| f32::from(u16::from_le_bytes(b)))?
            }
            (ComponentType::U32, _) => {
                self.numbers(index, element, count, |b| u32::from_le_bytes(b) as f32)?
            }
        };
        Ok(Scalars { values, width: n })
    }

    /// Elements of `N` unsigned integers: indices and joints.
    pub(super) fn integers<const N: usize>(&self, index: usize, user: &str) -> Result<Vec<[u32; N]>, Error> {
        let (element, count) = self.describe(index, &[N], user)?;
        let flat = match element.component {
            ComponentType::U8 => self.numbers(index, element, count, |b| u32::from(u8::from_le_bytes(b)))?,
            ComponentType::U16 => {
                self.numbers(index, element, count, |b| u32::from(u16::from_le_bytes(b)))?
            }
            ComponentType::U32 => self.numbers(index, element, count, u32::from_le_bytes)?,
            other => {
                let name = self.accessor_label(index);
                return Err(self.error(format!("{user}: {name} holds {other:?}, not unsigned integers")));
            }
        };
        Ok(group(flat))
    }

    fn accessor_label(&self, index: usize) -> String {
        label("accessor", index, self.root.accessors.get(index).and_then(|a| a.name.as_deref()))
    }

    /// Checks type and count, and books the memory.
    fn describe(&self, index: usize, widths: &[usize], user: &str) -> Result<(Element, usize), Error> {
        let accessor = self.item(&self.root.accessors, index, "accessor", user)?;
        let name = self.accessor_label(index);
        let component = self.known(&accessor.component_type, "componentType", &name)?.0;
        let kind = self.known(&accessor.type_, "type", &name)?;
        let width = kind.multiplicity();
        // Columns of small integer matrices are padded; nothing that we read has them.
        let matrix = matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4);
        if !widths.contains(&width) || (matrix && component != ComponentType::F32) {
            return Err(self.error(format!(
                "{user}: {name} has the type {kind:?} of {component:?}, which does not fit"
            )));
        }
        let count = accessor.count.0;
        self.charge(count, width * 4, format_args!("{user}: {name}"))?;
        let count =
            usize::try_from(count).map_err(|_| self.error(format!("{name}: count {count} is too large")))?;
        Ok((Element { component, width }, count))
    }

    /// Reads `count` elements of numbers of `B` bytes each, then puts sparse values in their places.
    fn numbers<const B: usize, T: Copy + Default>(
        &self,
        index: usize,
        element: Element,
        count: usize,
        number: impl Fn([u8; B]) -> T,
    ) -> Result<Vec<T>, Error> {
        let accessor = &self.root.accessors[index];
        let name = self.accessor_label(index);
        let mut out = Vec::new();
        match accessor.buffer_view {
            None => out.resize(count * element.width, T::default()),
            Some(view) => {
                let view = view.value();
                let stride = self.root.buffer_views.get(view).and_then(|v| v.byte_stride).map(|s| s.0);
                let place = Place { view, offset: accessor.byte_offset.unwrap_or_default().0, stride };
                let (bytes, stride) = self.elements(&name, &place, element.size(), count)?;
                out.reserve_exact(count * element.width);
                if stride == element.size() {
                    out.extend(bytes.as_chunks::<B>().0.iter().map(|&b| number(b)));
                } else {
                    for one in bytes.chunks(stride) {
                        out.extend(one[..element.size()].as_chunks::<B>().0.iter().map(|&b| number(b)));
                    }
                }
            }
        }
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, &name, element, count, number, &mut out)?;
        }
        Ok(out)
    }

    fn apply_sparse<const B: usize, T>(
        &self,
        sparse: &sparse::Sparse,
        name: &str,
        element: Element,
        count: usize,
        number: impl Fn([u8; B]) -> T,
        out: &mut [T],
    ) -> Result<(), Error> {
        let changes = usize::try_from(sparse.count.0).ok().filter(|&n| n <= count).ok_or_else(|| {
            self.error(format!("{name}: {} sparse values for {count} elements", sparse.count.0))
        })?;
        let kind = self.known(&sparse.indices.component_type, "componentType", name)?.0;
        let indices = Place {
            view: sparse.indices.buffer_view.value(),
            offset: sparse.indices.byte_offset.0,
            stride: None,
        };
        let values = Place {
            view: sparse.values.buffer_view.value(),
            offset: sparse.values.byte_offset.0,
            stride: None,
        };
        let (indices, _) = self.elements(name, &indices, kind.size(), changes)?;
        let (values, _) = self.elements(name, &values, element.size(), changes)?;
        for (at, value) in indices.chunks_exact(kind.size()).zip(values.chunks_exact(element.size())) {
            let target = at.iter().rev().fold(0usize, |sum, &byte| (sum << 8) | usize::from(byte));
            if target >= count {
                let what = format!("{name}: sparse index {target} out of range (there are {count} elements)");
                return Err(self.error(what));
            }
            let slot = &mut out[target * element.width..][..element.width];
            for (slot, &bytes) in slot.iter_mut().zip(value.as_chunks::<B>().0) {
                *slot = number(bytes);
            }
        }
        Ok(())
    }

    /// The bytes from the first element to the end of the last, and the distance from one to the next.
    fn elements(
        &self,
        name: &str,
        place: &Place,
        size: usize,
        count: usize,
    ) -> Result<(&[u8], usize), Error> {
        let bytes = self.view(place.view, name)?;
        let stride = place.stride.unwrap_or(size);
        if stride < size {
            return Err(
                self.error(format!("{name}: a stride of {stride} bytes for elements of {size} bytes"))
            );
        }
        let length = match count.checked_sub(1) {
            None => Some(0),
            Some(last) => last.checked_mul(stride).and_then(|n| n.checked_add(size)),
        };
        usize::try_from(place.offset)
            .ok()
            .zip(length)
            .and_then(|(start, length)| bytes.get(start..start.checked_add(length)?))
            .map(|bytes| (bytes, stride))
            .ok_or_else(|| {
                let (view, offset, there) = (place.view, place.offset, bytes.len());
                self.error(format!(
                    "{name}: {count} elements of {size} bytes, {stride} apart, at {offset} do not fit in buffer view {view} of {there} bytes"
                ))
            })
    }
}

/// Groups numbers by `N`, without a copy if the allocation allows it. Nothing remains: readers make whole elements.
fn group<T: bytemuck::Pod, const N: usize>(flat: Vec<T>) -> Vec<[T; N]> {
    bytemuck::allocation::try_cast_vec(flat).unwrap_or_else(|(_, flat)| flat.as_chunks::<N>().0.to_vec())
}

/// Where elements lie.
struct Place {
    view: usize,
    offset: u64,
    stride: Option<usize>,
}

/// Numbers of an accessor without their grouping.
pub(super) struct Scalars {
    pub(super) values: Vec<f32>,
    /// Numbers an element.
    pub(super) width: usize,
}

/// Checks that two arrays that belong together are equally long.
pub(super) fn same_length(
    source: &Source<'_>,
    user: &str,
    what: impl Display,
    got: usize,
    expected: usize,
) -> Result<(), Error> {
    if got == expected {
        return Ok(());
    }
    Err(source.error(format!("{user}: {what} has {got} entries where {expected} were expected")))
}
