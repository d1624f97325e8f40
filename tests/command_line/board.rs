//! The boards: constants that are those of their scene, a log that the program reads, and a chapter that shows the files as they are.

use crate::documents::{read, root};
use crate::support::Sandbox;
use ballrace::twin::DamageDetector;
use monitor::SAMPLES;

#[path = "../target/board/src/machine.rs"]
mod machine;
#[path = "../target/board/src/run.rs"]
#[expect(dead_code, reason = "the checksum is that of the emulated board")]
mod run;

const FOLDER: &str = "docs/boards/monitor";
/// Files of the scene.
const FILES: [&str; 5] = ["scene.toml", "mass.mtx", "damping.mtx", "stiffness.mtx", "load.mtx"];

#[test]
fn the_constants_are_those_of_their_scene() {
    let constants = root().join(FOLDER).join("bearings.rs");
    let answer = Sandbox::empty().run(&["verify", constants.to_str().unwrap()]);
    assert_eq!(answer.code, Some(0), "{answer:?}");
}

/// Returns the path in the repository and the text of each file of the scene.
pub fn scene_files() -> impl Iterator<Item = (String, String)> {
    FILES.iter().map(|name| format!("{FOLDER}/{name}")).map(|path| (path.clone(), read(path)))
}

/// Returns the log of a machine, as it leaves the board.
pub fn log(is_damaged: bool) -> Vec<u8> {
    let mut log = vec![];
    let detector = Box::leak(Box::new(DamageDetector::new()));
    run::run(is_damaged, detector, |_, frames, _| log.extend_from_slice(frames)).unwrap();
    log
}

/// Files of the scene and the log of a machine.
fn logged(is_damaged: bool) -> Sandbox {
    let sandbox = Sandbox::empty();
    for (path, text) in scene_files() {
        sandbox.put(path.strip_prefix("docs/boards/monitor/").unwrap(), text);
    }
    sandbox.put("board.frames", log(is_damaged));
    sandbox
}

/// The board has named the same (`tests/target_images/board.rs`).
#[test]
fn a_log_of_the_board_is_a_recording() {
    for is_damaged in [false, true] {
        let outcome = logged(is_damaged).replay("scene.toml", &[]);
        let text = outcome.to_string();
        let verdict = outcome["verdict"].as_str().unwrap();
        assert_eq!(verdict.starts_with("The vibration shows a fault. Outer race of DE"), is_damaged, "{verdict}");
        let found: Vec<&str> =
            outcome["findings"].as_array().unwrap().iter().map(|one| one["kind"].as_str().unwrap()).collect();
        assert_eq!(found, if is_damaged { &["outer-race"][..] } else { &[] }, "{verdict}");
        let samples = machine::BLOCKS * SAMPLES;
        assert!(text.contains(&format!("\"samples\":{samples}")), "{text}");
        // The railed channel is missing, and nothing else.
        assert!(text.contains("DE_X: no value in 300 samples"), "{text}");
        let force = outcome["bearings"][0].to_string();
        assert!(force.contains("mean"), "{force}");
    }
}

/// The instructions of a sample that the chapter states, from the table of the performance chapter.
#[test]
fn the_budget_is_that_of_the_counted_rows() {
    let table = include_str!("../../runner/studies/src/trade/cores/cortex-m4f.csv");
    let row = |start: &str| {
        let line = table.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}"));
        line.split(';').nth(5).unwrap().parse::<u32>().unwrap()
    };
    let block = row("radial 3/2;9;f32;exact;block of 16 samples, counts;") / 16;
    let sum = block + row("damage detector;9;f32;exact;sample;") + row("log;0;f32;exact;frame of 4 readings;");
    let text = read("docs/src/board.md");
    let stated = text.split_once("force, detector and frame are ").unwrap().1;
    let stated: u32 = stated.split(':').next().unwrap().parse().unwrap();
    assert!(stated.abs_diff(sum) <= 20, "{stated} instructions stated, {sum} counted");
}

/// `<!-- file: PATH -->` stands before a block of the chapter that is the file.
#[test]
fn the_chapter_shows_the_files_of_the_boards() {
    const MARK: &str = "<!-- file: ";
    let path = "docs/src/board.md";
    let text = read(path);
    let mut parts = text.split(MARK);
    let mut current = parts.next().unwrap().to_owned();
    let mut shown = vec![];
    for part in parts {
        let (name, rest) = part.split_once(" -->\n").unwrap();
        let (fence, rest) = rest.split_once('\n').unwrap();
        assert!(fence.starts_with("```"), "{name}: a block after its mark");
        let (_, after) = rest.split_once("```\n").unwrap();
        current += &format!("{MARK}{name} -->\n{fence}\n{}```\n{after}", read(name));
        shown.push(name);
    }
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(root().join(path), &current).unwrap();
    } else {
        assert_eq!(text, current, "BALLRACE_WRITE=1 copies the files");
    }
    for board in ["stm32g4", "rp2350"] {
        for name in ["Cargo.toml", "memory.x", ".cargo/config.toml", "build.rs", "src/main.rs"] {
            let path = format!("docs/boards/{board}/{name}");
            let same = board == "rp2350" && name == "build.rs";
            assert!(same || shown.contains(&path.as_str()), "{path} is not shown");
        }
    }
    assert_eq!(
        read("docs/boards/stm32g4/build.rs"),
        read("docs/boards/rp2350/build.rs"),
        "the chapter shows one of them"
    );
}
