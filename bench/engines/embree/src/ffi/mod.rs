//! The door to Embree 4's C interface: the few calls that are needed, declared by hand after `rtcore.h`, found in a shared
//! library at run time. The only place of the bench with `unsafe`.
#![allow(unsafe_code, reason = "a C interface")]

mod scene;

pub(crate) use scene::{Flags, Quality, Query, Scene};

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use libloading::Library;

/// `RTCDevice`, `RTCScene` and `RTCGeometry`: pointers to things that only Embree knows.
type Handle = *mut c_void;

/// `RTCRay8` and `RTCRay16`: one array a field, in the order of the header. `K` rays.
///
/// Aligned for the widest.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Rays<const K: usize> {
    pub(crate) origin: [[f32; K]; 3],
    pub(crate) near: [f32; K],
    pub(crate) direction: [[f32; K]; 3],
    pub(crate) time: [f32; K],
    /// Becomes minus infinity where something blocks.
    pub(crate) far: [f32; K],
    pub(crate) mask: [u32; K],
    pub(crate) id: [u32; K],
    pub(crate) flags: [u32; K],
}

impl<const K: usize> Rays<K> {
    /// Rays that no mask keeps from anything.
    pub(crate) fn new() -> Rays<K> {
        let zero = [0.0; K];
        Rays {
            origin: [zero; 3],
            near: zero,
            direction: [zero; 3],
            time: zero,
            far: zero,
            mask: [u32::MAX; K],
            id: [0; K],
            flags: [0; K],
        }
    }
}

/// Which rays of a packet count: -1 or 0 each.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Valid<const K: usize>(pub(crate) [i32; K]);

/// `RTCOccludedArguments`.
#[repr(C)]
struct Arguments {
    flags: c_int,
    feature_mask: c_int,
    context: *mut QueryContext,
    filter: *const c_void,
    occluded: *const c_void,
    /// Only in builds with `RTC_MIN_WIDTH`; others do not look.
    min_width_distance_factor: f32,
}

/// `RTCRayQueryContext`: instance ids, as many as the build has levels, and in some builds more; none is valid.
#[repr(C)]
struct QueryContext([u32; 16]);

/// The calls. Kept together with the library that they live in.
struct Calls {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    release_scene: unsafe extern "C" fn(Handle),
    scene_quality: unsafe extern "C" fn(Handle, c_int),
    scene_flags: unsafe extern "C" fn(Handle, c_int),
    attach: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    commit_scene: unsafe extern "C" fn(Handle),
    join_commit_scene: unsafe extern "C" fn(Handle),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    release_geometry: unsafe extern "C" fn(Handle),
    geometry_quality: unsafe extern "C" fn(Handle, c_int),
    shared_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, *const c_void, usize, usize, usize),
    update_buffer: unsafe extern "C" fn(Handle, c_int, c_uint),
    commit_geometry: unsafe extern "C" fn(Handle),
    occluded8: unsafe extern "C" fn(*const c_int, Handle, *mut Rays<8>, *mut Arguments),
    occluded16: unsafe extern "C" fn(*const c_int, Handle, *mut Rays<16>, *mut Arguments),
    /// Never unloaded: its worker threads may still be asleep in its code when the last device is gone.
    _library: ManuallyDrop<Library>,
}

impl Calls {
    fn load(path: &Path) -> Result<Calls> {
        // SAFETY: opening a library runs its initialisers; that this file is Embree is the caller's word, and a file that
        // lacks one of the names below is refused.
        let library = unsafe { Library::new(path) }
            .with_context(|| format!("{}: cannot be loaded as a shared library", path.display()))?;
        macro_rules! find {
            ($name:literal) => {
                // SAFETY: the field's type is the one that the header of version 4 declares under this name.
                *unsafe { library.get($name) }
                    .with_context(|| format!("{}: is not Embree 4", path.display()))?
            };
        }
        Ok(Calls {
            new_device: find!(b"rtcNewDevice\0"),
            release_device: find!(b"rtcReleaseDevice\0"),
            device_error: find!(b"rtcGetDeviceError\0"),
            device_property: find!(b"rtcGetDeviceProperty\0"),
            new_scene: find!(b"rtcNewScene\0"),
            release_scene: find!(b"rtcReleaseScene\0"),
            scene_quality: find!(b"rtcSetSceneBuildQuality\0"),
            scene_flags: find!(b"rtcSetSceneFlags\0"),
            attach: find!(b"rtcAttachGeometry\0"),
            commit_scene: find!(b"rtcCommitScene\0"),
            join_commit_scene: find!(b"rtcJoinCommitScene\0"),
            new_geometry: find!(b"rtcNewGeometry\0"),
            release_geometry: find!(b"rtcReleaseGeometry\0"),
            geometry_quality: find!(b"rtcSetGeometryBuildQuality\0"),
            shared_buffer: find!(b"rtcSetSharedGeometryBuffer\0"),
            update_buffer: find!(b"rtcUpdateGeometryBuffer\0"),
            commit_geometry: find!(b"rtcCommitGeometry\0"),
            occluded8: find!(b"rtcOccluded8\0"),
            occluded16: find!(b"rtcOccluded16\0"),
            _library: ManuallyDrop::new(library),
        })
    }
}

/// An Embree device: its settings and threads.
pub(crate) struct Device {
    calls: Calls,
    handle: Handle,
}

// SAFETY: Embree's manual: all calls on a device may be made from any thread; the handle is only a name for it.
unsafe impl Send for Device {}
// SAFETY: as above; errors are kept a thread.
unsafe impl Sync for Device {}

impl Device {
    /// Loads the library and makes a device. `settings` as in Embree's manual, e.g. `threads=2`.
    pub(crate) fn new(path: &Path, settings: &str) -> Result<Arc<Device>> {
        let calls = Calls::load(path)?;
        let text = CString::new(settings)?;
        // SAFETY: a string that ends in zero, and that Embree copies.
        let handle = unsafe { (calls.new_device)(text.as_ptr()) };
        if handle.is_null() {
            bail!("Embree makes no device of '{settings}'");
        }
        let device = Device { calls, handle };
        device.check("rtcNewDevice")?;
        if device.property(1) != 4 {
            bail!("{}: is Embree {}, not Embree 4", path.display(), device.version());
        }
        Ok(Arc::new(device))
    }

    /// E.g. `4.4.0`.
    pub(crate) fn version(&self) -> String {
        format!("{}.{}.{}", self.property(1), self.property(2), self.property(3))
    }

    /// Whether packets of 16 are one vector on this machine.
    pub(crate) fn has_native_16(&self) -> bool {
        self.property(34) != 0
    }

    fn property(&self, number: c_int) -> isize {
        // SAFETY: a live device and a number of `RTCDeviceProperty`.
        unsafe { (self.calls.device_property)(self.handle, number) }
    }

    /// Turns the last error of this thread into ours.
    fn check(&self, doing: &str) -> Result<()> {
        // SAFETY: a live device.
        match unsafe { (self.calls.device_error)(self.handle) } {
            0 => Ok(()),
            code => bail!("Embree: {doing}: {}", error_name(code)),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: made by `new`; scenes hold an `Arc` of the device, so that none is left.
        unsafe { (self.calls.release_device)(self.handle) };
    }
}

/// `RTCError` in words.
fn error_name(code: c_int) -> &'static str {
    match code {
        2 => "invalid argument",
        3 => "invalid operation",
        4 => "out of memory",
        5 => "this processor is not supported",
        6 => "cancelled",
        _ => "unknown error",
    }
}
