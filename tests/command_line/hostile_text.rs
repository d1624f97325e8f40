//! Text from files that would steer a terminal or bury a message.

use crate::support::{Answer, DEMO_SCENE, SHORT, Sandbox, short_recording, swap};

/// Clears the screen, sets the window's title, writes in red; an 8-bit escape; a line that looks like the program's own.
const HOSTILE: &str = "\u{1b}]0;title\u{7}\u{1b}[2J\u{1b}[31m\u{9b}1m\u{202e}";
/// Longest message, bytes.
const LONGEST: usize = 8 << 10;

/// Nothing in it steers a terminal.
fn assert_printable(answer: &Answer) {
    for text in [&answer.out, &answer.err] {
        let bad = text.chars().find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}');
        assert_eq!(bad, None, "{answer:?}");
    }
}

/// One line, bounded and printable, that has all `parts`.
fn refused(sandbox: &Sandbox, args: &[&str], parts: &[&str]) {
    let answer = sandbox.run(args);
    assert!(matches!(answer.code, Some(1 | 2)), "{:?}", answer.code);
    assert!(answer.err.len() < LONGEST, "a message of {} bytes", answer.err.len());
    assert_eq!(answer.err.lines().count(), 1, "{answer:?}");
    assert_printable(&answer);
    for part in parts {
        assert!(answer.err.contains(part), "{part:?} is missing: {answer:?}");
    }
}

/// The demonstration's recording with the column DE_X_um under another name.
fn renamed(name: &str) -> Sandbox {
    Sandbox::with(DEMO_SCENE, &swap(&short_recording(SHORT), "DE_X_um", name))
}

#[test]
fn control_characters_of_a_column_name_are_escaped() {
    let absent = ["healthy.csv", "no such column: `DE_X_um`", "\\u{1b}]0;title"];
    refused(&renamed(HOSTILE), &["replay", "scene.toml"], &absent);
    let two_lines = "\"DE\nballrace: all is well\"";
    refused(&renamed(two_lines), &["replay", "scene.toml"], &["healthy.csv"]);
}

#[test]
fn a_column_name_of_a_megabyte_is_cut() {
    let sandbox = renamed(&"x".repeat(1 << 20));
    refused(&sandbox, &["replay", "scene.toml"], &["healthy.csv"]);
    let sandbox = renamed(&"\u{1b}".repeat(60_000));
    refused(&sandbox, &["replay", "scene.toml"], &["healthy.csv", "no such column: `DE_X_um`"]);
}

#[test]
fn control_characters_of_a_cell_are_escaped() {
    for cell in [HOSTILE.to_owned(), "y".repeat(1 << 20)] {
        let text = crate::support::edited_recording(|line, row| {
            vec![if line == 9 { crate::support::with_cell(row, 1, &cell) } else { row.to_owned() }]
        });
        refused(&Sandbox::with(DEMO_SCENE, &text), &["replay", "scene.toml"], &["healthy.csv:9: column", "DE_X_um"]);
    }
}

#[test]
fn control_characters_of_displacements_are_escaped() {
    let args = ["force", "scene.toml", "--bearing", "DE", "--displacements", "d.csv"];
    let long = "z".repeat(1 << 20);
    let texts = [
        format!("u,v,w,thu,{HOSTILE}\n0,0,0,0,0\n"),
        format!("u,v,w,thu,{long}\n0,0,0,0,0\n"),
        format!("u,v,w,thu,thv\n0,0,0,0,{HOSTILE}\n"),
        format!("u,v,w,thu,thv\n0,0,0,0,{long}\n"),
    ];
    for text in texts {
        let sandbox = Sandbox::rig();
        sandbox.put("d.csv", text);
        refused(&sandbox, &args, &["d.csv:"]);
    }
}

#[test]
fn control_characters_of_an_array_file_are_escaped() {
    let head = format!("{{'descr': '{HOSTILE}', 'fortran_order': False, 'shape': (3,), }}\n");
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend(u16::try_from(head.len()).unwrap().to_le_bytes());
    npy.extend(head.bytes());
    let sandbox = Sandbox::rig();
    sandbox.put("r.npy", npy);
    refused(&sandbox, &["replay", "scene.toml", "--recording", "r.npy"], &["r.npy"]);
}

/// Names of a scene are refused with their control characters escaped.
#[test]
fn control_characters_of_scene_names_are_escaped() {
    for name in ["DE", "6205 rig", "DE_X_um"] {
        let hostile = "\"\\u001b[2J\\u001b]0;title\\u0007\\u009b1m\"";
        let scene = swap(DEMO_SCENE, &format!("\"{name}\""), hostile);
        let sandbox = Sandbox::with(&scene, &short_recording(SHORT));
        refused(&sandbox, &["replay", "scene.toml"], &["scene.toml:", "[2J"]);
    }
}
