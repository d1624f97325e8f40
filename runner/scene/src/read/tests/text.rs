//! Files and texts that are no scene: one error, never a panic.

use super::*;

#[test]
fn text_that_is_no_scene() {
    let shown = |text: &str| refusal_of_file(read(text));
    for nothing in ["", "\n\n", "# only a comment\n", "\u{feff}"] {
        assert!(shown(nothing).starts_with("machines/pump.toml: an empty file, expected a scene"));
    }
    let unit = with(MINIMAL, "\"50 mm\"", "50 mm");
    assert_eq!(
        shown(&unit),
        "machines/pump.toml:9: not TOML at \"pitch_diameter = 50 mm\": string values must be quoted, \
         expected literal string"
    );
    assert!(shown("time_s,x\n0,1\n").contains("pump.toml:1: not TOML"));
    let twice = with(MINIMAL, "station = 0", "station = 0\nstation = 0");
    assert!(shown(&twice).contains(":6: not TOML at \"station = 0\": duplicate key"));
    assert!(shown(&"[".repeat(100_000)).contains("not TOML"));
    assert!(shown(&format!("a = {}", "[".repeat(100_000))).contains("not TOML"));
}

fn refusal_of_file(result: Read<Scene>) -> String {
    let shown = result.unwrap_err().to_string();
    assert!(!shown.contains('\n'), "{shown}");
    shown
}

#[test]
fn files_that_cannot_be_read() {
    let folder = std::env::temp_dir().join(format!("ballrace-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let shown = |name: &str| refusal_of_file(read_file(&folder.join(name)));
    assert!(shown("absent.toml").ends_with(
        "absent.toml: no file of this name, expected a scene file (TOML text with at least [shaft] and one \
         [[bearing]])"
    ));
    assert!(shown("").contains(": a directory, expected a scene file"));
    std::fs::write(folder.join("latin.toml"), b"# fine\nname = \"M\xfcller\"\n").unwrap();
    assert!(shown("latin.toml").contains("latin.toml:2: bytes that are not UTF-8"));
    std::fs::write(folder.join("large.toml"), vec![b'#'; (4 << 20) + 1]).unwrap();
    assert!(shown("large.toml").contains("more than 4 MiB"));
    std::fs::write(folder.join("good.toml"), SPINDLE).unwrap();
    let scene = read_file(&folder.join("good.toml")).unwrap();
    assert_eq!(scene.recording.unwrap().file, folder.join("healthy.csv"));
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A small generator of pseudo-random numbers (xorshift), so that a failure can be repeated.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % limit.max(1) as u64).unwrap()
    }
}

#[test]
#[rustfmt::skip] // a table
fn no_text_makes_it_panic() {
    let text = format!("{SPINDLE}{}", LUMPED.replace("[shaft]\nspeed = 100\n", ""));
    for end in 0..text.len() {
        check_any(text.get(..end).unwrap_or_default());
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let junk = [
        "\"",
        "[",
        "]",
        "{",
        "}",
        "=",
        "\n",
        "nan",
        "-inf",
        "1e999",
        "-1",
        "0",
        "9223372036854775807",
        "\u{b5}",
        "^",
        "/",
        "'",
        "#",
        ".",
        ",",
        "true",
        "\"\"",
        "[[",
        "\\",
        "\u{0}",
        "\u{feff}",
        "1e-320",
        "1979-05-27",
        "\"5 um^9\"",
    ];
    for _ in 0..1500 {
        let mut mutated: Vec<char> = text.chars().collect();
        for _ in 0..1 + random.below(4) {
            let at = random.below(mutated.len());
            let end = (at + random.below(12)).min(mutated.len());
            let piece = junk.get(random.below(junk.len())).unwrap();
            mutated.splice(at..end, piece.chars());
        }
        check_any(&mutated.into_iter().collect::<String>());
    }
}

#[test]
#[rustfmt::skip] // a table
fn no_value_makes_it_panic() {
    for line in SPINDLE.lines().filter(|l| l.contains(" = ")) {
        let key = line.split(" = ").next().unwrap();
        for value in [
            "nan",
            "inf",
            "-1",
            "0",
            "1e308",
            "-1e308",
            "1e-320",
            "9223372036854775807",
            "true",
            "[]",
            "{}",
            "\"\"",
            "\"1e308 ft\"",
            "\"1 m^-10\"",
            "\"nan m\"",
            "1979-05-27",
            "[[[]]]",
            "{ a = 1 }",
            "[1, 2, 3, 4, 5]",
        ] {
            check_any(&with(SPINDLE, line, &format!("{key} = {value}")));
        }
        check_any(&with(SPINDLE, line, ""));
    }
}

/// Any text gives a scene of finite numbers or one line.
fn check_any(text: &str) {
    match read(text) {
        Ok(scene) => {
            let shown = format!("{scene:?}");
            assert!(!shown.contains("NaN") && !shown.contains(": inf"), "{shown}");
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
}
