//! Any text as a scene: a scene or one error, and whatever is read can be built into bearings or is refused.
#![no_main]

use ballrace_twin::scene::build;
use ballrace_twin::scene::read::read_str;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let Ok(scene) = read_str(text, Path::new("scene.toml")) else { return };
    for bearing in &scene.bearings {
        // A table is a minute's work that no text should start here.
        if bearing.model != ballrace_twin::scene::Model::Tabulated {
            let _ = build::bearing(&scene, bearing, bearing.model);
        }
        let _ = build::kinematics(&scene, bearing);
    }
});
