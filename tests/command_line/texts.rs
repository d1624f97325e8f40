//! Every text that the program prints, in one file to be read by people, and slips that a machine can find in it.

use crate::support::{
    DEMO_SCENE, HEALTHY_RECORDING, SHORT, Sandbox, changed, edited_recording, recorded, short_recording, swap,
};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Command line and its output.
#[derive(Default)]
struct Texts(String);

impl Texts {
    fn add(&mut self, sandbox: &Sandbox, args: &[&str]) {
        let answer = sandbox.run(args);
        let code = answer.code.unwrap();
        writeln!(self.0, "$ ballrace {}\n{}{}[exit {code}]\n", args.join(" "), answer.out, answer.err).unwrap();
    }

    /// Writes the file; fails at what no text should have.
    fn finish(self, name: &str) {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::write(&path, &self.0).unwrap();
        println!("{}", path.display());
        let slips: Vec<String> = self.0.lines().filter_map(|line| Some(format!("{}: {line}", slip(line)?))).collect();
        assert!(slips.is_empty(), "{}", slips.join("\n"));
    }
}

/// Names the slip that a line has.
fn slip(line: &str) -> Option<&'static str> {
    // A message may name NaN as an allowed value of a cell.
    if line.starts_with('$') || line.contains("a number, or NaN") {
        return None;
    }
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_word = |word: &str| word.len() > 2 && word.chars().all(char::is_alphabetic);
    // A table's head may name a unit twice.
    let is_sentence = !line.contains("   ");
    let bare = |word: &'_ str| word.trim_end_matches(|c: char| !c.is_alphabetic()).to_owned();
    if is_sentence && words.windows(2).any(|pair| pair[0] == bare(pair[1]) && is_word(pair[0])) {
        return Some("a word twice");
    }
    let plural =
        |word: &str| is_word(word) && word.ends_with('s') && !matches!(word, "is" | "was" | "has" | "times" | "ms");
    if is_sentence && words.windows(2).any(|pair| pair[0] == "1" && plural(pair[1])) {
        return Some("one of many");
    }
    let is_minus_zero = |word: &str| word.strip_prefix("-0.").is_some_and(|rest| rest.chars().all(|c| c == '0'));
    let is_zero_in_tens = |word: &str| word.split_once("e0").is_some_and(|(zero, _)| zero.parse() == Ok(0.0));
    if words.iter().any(|word| matches!(*word, "NaN" | "inf" | "-inf") || is_minus_zero(word) || is_zero_in_tens(word))
    {
        return Some("no number for people");
    }
    line.contains("\"\"").then_some("an empty name")
}

fn scenes(texts: &mut Texts) -> Vec<String> {
    let sandbox = Sandbox::empty();
    texts.add(&sandbox, &["scenes"]);
    let all: Vec<serde_json::Value> = sandbox.done(&["scenes", "--format", "json"]).json();
    all.iter().map(|one| one["name"].as_str().unwrap().to_owned()).collect()
}

/// Messages of wrong scenes, recordings and options.
fn errors(texts: &mut Texts) {
    let sandbox = Sandbox::rig();
    let bad_scenes = [
        ("mass = \"6 kg\"", "mass = \"6 m\""),
        ("mass = \"6 kg\"", "mas = \"6 kg\""),
        ("mass = \"6 kg\"", "mass = -6"),
        ("mass = \"6 kg\"\n", ""),
        ("file = \"healthy.csv\"", "file = \"absent.csv\""),
        ("DE_X_um", "DE_X_mm"),
    ];
    for (from, to) in bad_scenes {
        sandbox.put("bad.toml", swap(DEMO_SCENE, from, to));
        texts.add(&sandbox, &["replay", "bad.toml"]);
    }
    let bad_recordings = [
        String::new(),
        "a,b\n".to_owned(),
        "1,2\n3,4\n".to_owned(),
        edited_recording(|line, row| vec![if line == 9 { row.replace('.', "x") } else { row.to_owned() }]),
        edited_recording(|line, row| if (50..60).contains(&line) { vec![] } else { vec![row.to_owned()] }),
        edited_recording(|line, row| if line < 20 { vec![row.to_owned()] } else { vec![] }),
        changed(SHORT, |_, k, x| if (1..6).contains(&k) { 0.0 } else { x }),
        changed(SHORT, |_, k, x| if (1..6).contains(&k) { f64::NAN } else { x }),
        changed(SHORT, |_, k, x| if k == 2 { 0.0 } else { x }),
    ];
    for text in bad_recordings {
        sandbox.put("bad.csv", text);
        texts.add(&sandbox, &["replay", "scene.toml", "--recording", "bad.csv"]);
    }
    sandbox.put("machines.csv", "machine,scene,time\nfan,bad.toml,\npump,absent.toml,monday\n");
    let commands: [&[&str]; 10] = [
        &[],
        &["fleet", "machines.csv", "-o", "fleet"],
        &["replay", "absent.toml"],
        &["replay", "--help"],
        &["watch"],
        &["scenes", "absent"],
        &["simulate", "scene.toml", "--duration", "1", "--rate", "no", "-o", "m.csv"],
        &["sweep", "scene.toml", "--over", "nothing=1..2:3", "-o", "s"],
        &["equilibrium", "scene.toml", "--bearing", "absent"],
        &["force", "scene.toml", "--displacements", "absent.csv"],
    ];
    for args in commands {
        texts.add(&sandbox, args);
    }
}

#[test]
fn printed_texts_have_no_slips() {
    let mut texts = Texts::default();
    let sandbox = Sandbox::rig();
    sandbox.put("d.csv", "u,v,w,thu,thv\n1e-6,0,1e-6,0,0\nnan,0,0,0,0\n");
    sandbox.put("machines.csv", "machine,scene\nrig,scene.toml\nlost,absent.toml\n");
    let commands: [&[&str]; 9] = [
        &["replay", "scene.toml"],
        &["fleet", "machines.csv", "-o", "fleet"],
        &["equilibrium", "scene.toml"],
        &["campbell", "scene.toml", "--speeds", "0rpm..3000rpm:2"],
        &["force", "scene.toml", "--bearing", "DE", "--displacements", "d.csv"],
        &["bake", "scene.toml", "-o", "baked.rs"],
        &["fmu", "scene.toml", "-o", "rotor.fmu"],
        &["fmu", "scene.toml", "--bearing", "DE", "-o", "bearing.fmu"],
        &["sweep", "scene.toml", "--over", "shaft.speed=2000rpm..3000rpm:2", "--periods", "16", "-o", "sweep"],
    ];
    for args in commands {
        texts.add(&sandbox, args);
    }
    errors(&mut texts);
    texts.finish("texts.txt");
}

/// The same with all that takes long: every shipped scene, every recording, real time, limits, trade, fit.
#[test]
#[ignore = "slow: runs every shipped scene and recording; tests/run --all runs it"]
fn long_printed_texts_of_recordings_have_no_slips() {
    let mut texts = Texts::default();
    let sandbox = Sandbox::empty();
    for name in scenes(&mut texts) {
        sandbox.put(&name, sandbox.done(&["scenes", &name]).out);
        texts.add(&sandbox, &["equilibrium", &name]);
        texts.add(&sandbox, &["simulate", &name, "--duration", "1 ms", "--rate", "1 kHz", "-o", "motion.csv"]);
    }
    for name in ["outer-spall", "unbalanced", "run-up"] {
        let sandbox = Sandbox::empty();
        for end in ["toml", "csv"] {
            let text = fs::read_to_string(recorded(&format!("{name}.{end}"))).unwrap();
            sandbox.put(&format!("{name}.{end}"), text);
        }
        texts.add(&sandbox, &["replay", &format!("{name}.toml")]);
    }
    let sandbox = Sandbox::with(DEMO_SCENE, HEALTHY_RECORDING);
    let limit = "\n[[limit]]\nindicator = \"peak-to-peak\"\nmax = \"0.1 um\"\n";
    sandbox.put("limit.toml", format!("{DEMO_SCENE}{limit}"));
    sandbox.put("short.csv", short_recording(SHORT));
    let commands: [&[&str]; 6] = [
        &["replay", "scene.toml"],
        &["replay", "limit.toml"],
        &["replay", "limit.toml", "--paced"],
        &["replay", "scene.toml", "--recording", "short.csv"],
        &["trade", "scene.toml", "--error", "0.1%"],
        &["fit", "scene.toml", "--only", "unbalance"],
    ];
    for args in commands {
        texts.add(&sandbox, args);
    }
    texts.finish("texts-of-recordings.txt");
}

#[test]
fn slips_are_found() {
    assert_eq!(slip("keyphasor keyphasor, 50 pulses"), Some("a word twice"));
    assert_eq!(slip("1 steps a sample"), Some("one of many"));
    assert_eq!(slip("film 0.0e0 %"), Some("no number for people"));
    assert_eq!(slip("DE_X_um: 0.00e0 um peak to peak"), Some("no number for people"));
    assert_eq!(slip("1 sample at 1000 Hz, 100 integration steps per sample"), None);
}
