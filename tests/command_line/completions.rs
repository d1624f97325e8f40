//! Shell completions and manual pages: every command and option of `--help`, in its words.

use crate::support::{Sandbox, program};
use std::process::{Command, Stdio};

/// Standard output of the program, which must succeed.
fn printed(arguments: &[&str]) -> String {
    let answer = Sandbox::empty().run(arguments);
    assert_eq!(answer.code, Some(0), "{answer:?}");
    assert!(answer.err.is_empty(), "{answer:?}");
    answer.out
}

/// Names of the commands in the help text.
fn commands() -> Vec<String> {
    let help = printed(&["--help"]);
    let list = help.split_once("Commands:").unwrap().1.split_once("Options:").unwrap().0;
    list.lines().filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

/// Long options in the help text of a command.
fn options(command: &str) -> Vec<String> {
    let help = printed(&[command, "--help"]);
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let longs = lines.filter_map(|line| line.split([' ', ',']).find(|word| word.starts_with("--")));
    longs.map(str::to_owned).collect()
}

#[test]
fn completions_name_every_command_and_option() {
    let commands = commands();
    assert!(commands.len() > 10, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = printed(&["completions", shell]);
        for name in commands.iter().filter(|name| *name != "help") {
            assert!(script.contains(name.as_str()), "{shell}: {name}");
            for option in options(name) {
                // Fish names options without their dashes.
                assert!(script.contains(option.trim_start_matches('-')), "{shell}: {name} {option}");
            }
        }
    }
}

#[test]
fn bash_completes_commands() {
    let script = printed(&["completions", "bash"]);
    let sandbox = Sandbox::empty();
    sandbox.put("script", &script);
    let line = "source ./script; COMP_WORDS=(ballrace equi); COMP_CWORD=1; _ballrace ballrace equi ballrace; echo \"${COMPREPLY[@]}\"";
    let output = Command::new("bash").args(["-c", line]).current_dir(sandbox.path("")).stdin(Stdio::null()).output();
    let output = output.expect("bash");
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "equilibrium", "{output:?}");
}

/// Text of a manual page: requests, fonts and escapes of roff removed.
fn text_of(roff: &str) -> String {
    let lines = roff
        .lines()
        .map(|line| line.strip_prefix('.').map_or(line, |request| request.split_once(' ').map_or("", |r| r.1)));
    let text = lines.collect::<Vec<_>>().join(" ");
    let text = ["\\fB", "\\fI", "\\fR"].iter().fold(text, |text, font| text.replace(font, ""));
    text.replace("\\-", "-").replace("\\*(Aq", "'").replace("\\&", "").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn manual_pages_describe_the_options_as_the_help_does() {
    let general = printed(&["man"]);
    assert!(general.contains(".TH ballrace 1"), "{general}");
    for name in commands().iter().filter(|name| *name != "help") {
        assert!(text_of(&general).contains(&format!("ballrace-{name}")), "{name}: {general}");
        let page = printed(&["man", name]);
        assert!(page.contains(&format!(".TH ballrace-{name} 1")), "{page}");
        let text = text_of(&page);
        for option in options(name) {
            assert!(text.contains(&option), "{name} {option}: {text}");
        }
        let help = printed(&[name, "--help"]);
        let about = help.lines().next().unwrap();
        assert!(text.contains(about), "{name}: {about}: {text}");
    }
}

#[test]
fn an_unknown_command_has_no_manual_page() {
    let answer = Sandbox::empty().run(&["man", "nonsense"]);
    assert_eq!(answer.code, Some(2), "{answer:?}");
    assert!(
        answer.err.starts_with("ballrace: man: unknown command: \"nonsense\", expected one of replay, "),
        "{answer:?}"
    );
    assert!(answer.out.is_empty(), "{answer:?}");
    assert!(program().exists());
}
