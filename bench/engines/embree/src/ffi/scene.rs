//! One triangle mesh in one scene, rebuilt every frame, and the occlusion query.

use std::ffi::{c_int, c_void};
use std::ptr;
use std::sync::Arc;

use anyhow::Result;
use bench_common::Case;

use super::{Arguments, Device, Handle, QueryContext, Rays, Valid};

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    Low = 0,
    Medium = 1,
    High = 2,
}

/// `RTCSceneFlags`, those of interest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flags {
    pub(crate) dynamic: bool,
    pub(crate) robust: bool,
}

const INDEX: c_int = 0;
const VERTEX: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const FEATURE_TRIANGLE: c_int = 1 << 1;
const COHERENT: c_int = 1 << 16;

/// A scene with the triangles of a case, shared with it, not copied.
pub(crate) struct Scene {
    device: Arc<Device>,
    scene: Handle,
    geometry: Handle,
    /// What Embree's buffers point to.
    _case: Arc<Case>,
    _corners: Vec<[u32; 3]>,
}

// SAFETY: Embree's manual: a committed scene may be queried by any number of threads; changing it takes `&mut self` here.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

impl Scene {
    /// Attaches the triangles. Nothing is built yet.
    pub(crate) fn new(
        device: &Arc<Device>,
        case: &Arc<Case>,
        quality: Quality,
        flags: Flags,
    ) -> Result<Scene> {
        let calls = &device.calls;
        let triangles = case.triangles();
        let corners: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let flag_bits = c_int::from(flags.dynamic) | c_int::from(flags.robust) << 2;
        // SAFETY: handles are used with the device that made them. Both buffers live as long as the scene, which owns them
        // through `_case` and `_corners`; the vertices have a triangle's worth of bytes after the last one (`Case`), of which
        // Embree may read 4; corners are within range.
        let (scene, geometry) = unsafe {
            let scene = (calls.new_scene)(device.handle);
            (calls.scene_quality)(scene, quality as c_int);
            (calls.scene_flags)(scene, flag_bits);
            let geometry = (calls.new_geometry)(device.handle, 0);
            (calls.geometry_quality)(geometry, quality as c_int);
            let share = |what: c_int, format: c_int, data: *const c_void, count: usize| {
                (calls.shared_buffer)(geometry, what, 0, format, data, 0, 12, count);
            };
            share(VERTEX, FLOAT3, triangles.as_ptr().cast(), triangles.len() * 3);
            share(INDEX, UINT3, corners.as_ptr().cast(), corners.len());
            (calls.commit_geometry)(geometry);
            (calls.attach)(scene, geometry);
            (scene, geometry)
        };
        let scene = Scene { device: device.clone(), scene, geometry, _case: case.clone(), _corners: corners };
        device.check("making the scene")?;
        Ok(scene)
    }

    /// Builds the hierarchy as if every vertex had moved, with the device's threads.
    pub(crate) fn rebuild(&mut self) -> Result<()> {
        self.touch();
        // SAFETY: a live scene that nobody else queries now (`&mut self`).
        unsafe { (self.device.calls.commit_scene)(self.scene) };
        self.device.check("building")
    }

    /// The same with the threads of the current rayon pool, all of which join in.
    pub(crate) fn rebuild_joined(&mut self) -> Result<()> {
        self.touch();
        let scene = &*self;
        // SAFETY: a live scene that nobody queries now; any number of threads may join one commit.
        rayon::broadcast(|_| unsafe { (scene.device.calls.join_commit_scene)(scene.scene) });
        self.device.check("building")
    }

    fn touch(&mut self) {
        let calls = &self.device.calls;
        // SAFETY: live handles; the buffer was set in `new`.
        unsafe {
            (calls.update_buffer)(self.geometry, VERTEX, 0);
            (calls.commit_geometry)(self.geometry);
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        let calls = &self.device.calls;
        // SAFETY: made by `new`, released once; the buffers outlive this call.
        unsafe {
            (calls.release_geometry)(self.geometry);
            (calls.release_scene)(self.scene);
        }
    }
}

/// Questions of one thread to one scene.
pub(crate) struct Query<'a> {
    scene: &'a Scene,
    context: QueryContext,
    flags: c_int,
}

impl<'a> Query<'a> {
    pub(crate) fn new(scene: &'a Scene, coherent: bool) -> Query<'a> {
        let context = QueryContext([u32::MAX; 16]);
        Query { scene, context, flags: if coherent { COHERENT } else { 0 } }
    }

    fn arguments(&mut self) -> Arguments {
        Arguments {
            flags: self.flags,
            feature_mask: FEATURE_TRIANGLE,
            context: &raw mut self.context,
            filter: ptr::null(),
            occluded: ptr::null(),
            min_width_distance_factor: 0.0,
        }
    }

    /// `far` of those of the rays that something blocks becomes minus infinity.
    #[inline]
    pub(crate) fn occluded8(&mut self, valid: &Valid<8>, rays: &mut Rays<8>) {
        let mut arguments = self.arguments();
        let call = self.scene.device.calls.occluded8;
        // SAFETY: a committed scene; packet and flags have the header's layout and alignment, the arguments are as the
        // header initialises them, and their context lives as long as `self`.
        unsafe { call(valid.0.as_ptr(), self.scene.scene, rays, &raw mut arguments) }
    }

    /// The same for sixteen.
    #[inline]
    pub(crate) fn occluded16(&mut self, valid: &Valid<16>, rays: &mut Rays<16>) {
        let mut arguments = self.arguments();
        let call = self.scene.device.calls.occluded16;
        // SAFETY: as in `occluded8`.
        unsafe { call(valid.0.as_ptr(), self.scene.scene, rays, &raw mut arguments) }
    }
}
