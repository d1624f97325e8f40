//! Any bytes as a recording in CSV: rows and flaws, or one error.
#![no_main]

use ballrace_twin::recording::Reader;
use ballrace_twin::recording::rotation::Tracker;
use ballrace_twin::scene::Scene;
use ballrace_twin::scene::read::read_str;
use libfuzzer_sys::fuzz_target;
use std::io::Cursor;
use std::path::Path;
use std::sync::LazyLock;

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let text = include_str!("../../../runner/demo/healthy.toml");
    read_str(text, Path::new("healthy.toml")).expect("the demonstration")
});

fuzz_target!(|bytes: &[u8]| {
    let Some(recording) = &SCENE.recording else { return };
    let bytes = bytes.to_vec();
    let Ok(mut reader) = Reader::from_reader(Box::new(Cursor::new(bytes)), Path::new("fuzz.csv"), None, recording)
    else {
        return;
    };
    let mut tracker = Tracker::new(&recording.rotation, reader.rate(), SCENE.shaft.speed);
    let mut row = tracker.blank();
    while let Ok(true) = reader.next_row(&mut row) {
        if tracker.push(row).is_err() {
            return;
        }
        while let Some(sample) = tracker.pop() {
            assert!(sample.speed.is_finite() && sample.row.time.is_finite());
            tracker.recycle(sample.row);
        }
        row = tracker.blank();
    }
    let _ = tracker.finish();
});
