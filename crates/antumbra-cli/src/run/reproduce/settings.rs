//! The scenes, cameras and lights of the page. Files are sought in the folder of scenes.

use super::bench::Setting;

const SQUARE: [usize; 2] = [1024, 1024];
pub(super) const HD: [usize; 2] = [1920, 1080];
pub(super) const UHD: [usize; 2] = [3840, 2160];

/// The atrium that K21 measures, with the very number of triangles.
pub(super) const SPONZA: Setting = Setting {
    stand_in: Some("builtin:atrium"),
    view: Some([[1100.0, 350.0, 0.0], [0.0, 300.0, 0.0]]),
    light: Some([-200.0, 600.0, -50.0]),
    ..Setting::new("sponza", "crytek_sponza/sponza.glb", HD)
};

/// The animation of OA11's figures 6 and 7, with a light over the square: the file's own is above the sky dome's
/// clouds, and leaves whole frames dark.
pub(super) const ROBOTS: Setting = Setting {
    stand_in: Some("builtin:crowd"),
    light: Some([0.0, 45.0, 100.0]),
    ..Setting::new("robots", "bart_robots/bart_robots.glb", SQUARE)
};

/// The scene of OA11's table 2, at the tessellation of the file.
pub(super) const MUSEUM: Setting = Setting::new("museum", "bart_museum/bart_museum.glb", SQUARE);

/// The same with its 1,024 moving triangles cut in 64 each: 76,204 triangles, as near as can be to the paper's 75,948.
pub(super) const MUSEUM_FINE: Setting =
    Setting { name: "museum, fine", tessellate: Some(("animated_triangles", 3)), ..MUSEUM };

/// About as many triangles as SOA11's game scene, of open and overlapping parts too.
pub(super) const BUILDING: Setting = Setting {
    view: Some([[-15.0, 14.0, -40.0], [11.0, 5.0, -11.0]]),
    light: Some([-5.0, 20.0, -30.0]),
    ..Setting::new("schependomlaan", "schependomlaan_bim/schependomlaan_bim.glb", SQUARE)
};

pub(super) const ROOM: Setting = Setting::new("builtin:room", "builtin:room", SQUARE);
pub(super) const CITY: Setting = Setting::new("builtin:city", "builtin:city?size=60000", SQUARE);
pub(super) const FOREST: Setting = Setting::new("builtin:forest", "builtin:forest?size=60000", SQUARE);
/// Hairs as thin as pixels before a wall: a depth edge in nearly every quad of the foreground.
pub(super) const HAIR: Setting = Setting::new("builtin:hairball", "builtin:hairball?size=30000", SQUARE);
