use std::fmt::Write;
use std::path::PathBuf;

const BEGIN: &str = "<!-- counts:begin -->\n";
const END: &str = "<!-- counts:end -->";
/// A count may rise by this share before the test fails, and fall by it before it asks for a new table.
const MARGIN: f64 = 0.02;

struct Count {
    /// What, elements, math.
    name: String,
    least: u32,
    most: u32,
}

fn measured() -> Vec<Count> {
    super::run("counts")
        .lines()
        .map(|line| {
            // The name may hold commas; the last two cells are the counts.
            let (rest, most) = line.rsplit_once(',').expect("a count");
            let (name, least) = rest.rsplit_once(',').expect("a count");
            let number = |text: &str| text.parse().expect("a number");
            Count { name: name.to_owned(), least: number(least), most: number(most) }
        })
        .collect()
}

fn readme() -> PathBuf {
    super::root().join("README.md")
}

/// Compilers differ in what they make of the same source: counts are held for the one that wrote the table.
fn compiler() -> String {
    let output = std::process::Command::new("rustc").arg("--version").output().expect("rustc runs");
    String::from_utf8_lossy(&output.stdout).split(" (").next().unwrap_or_default().trim().to_owned()
}

fn table(counts: &[Count]) -> String {
    let head = "| instructions on a Cortex-M4F, f32 | |\n| --- | --: |\n";
    let mut text = format!("Compiled by {}, optimised for speed.\n\n{head}", compiler());
    for count in counts {
        writeln!(text, "| {} | {} |", count.name, count.most).expect("a string takes it");
    }
    text
}

fn section(readme: &str) -> (usize, usize) {
    let begin = readme.find(BEGIN).expect("the README marks where the counts begin") + BEGIN.len();
    (begin, begin + readme[begin..].find(END).expect("and where they end"))
}

/// So many instructions, whatever the input: 700 of them, with NaN, infinities, subnormals, lost contact.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn counts_do_not_depend_on_the_input_and_stand_in_the_readme() {
    let counts = measured();
    assert!(counts.len() >= 30, "{} counts", counts.len());
    for count in &counts {
        assert_eq!(count.least, count.most, "{}: the count depends on the input", count.name);
    }
    let text = std::fs::read_to_string(readme()).expect("a README");
    let (begin, end) = section(&text);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        let written = format!("{}{}{}", &text[..begin], table(&counts), &text[end..]);
        std::fs::write(readme(), written).expect("the README takes it");
        return;
    }
    if !text[begin..end].contains(&format!("Compiled by {},", compiler())) {
        println!("the README's counts are of another compiler than {}: not compared", compiler());
        return;
    }
    let rows: Vec<&str> = text[begin..end].lines().skip(4).collect();
    assert_eq!(rows.len(), counts.len(), "the README's table lists other functions: BALLRACE_WRITE=1 rewrites it");
    for (row, count) in rows.iter().zip(&counts) {
        let (name, stated) = row.trim_matches(['|', ' ']).rsplit_once('|').expect("two columns");
        assert_eq!(name.trim(), count.name);
        let stated: f64 = stated.trim().parse().expect("a number");
        let change = f64::from(count.most) / stated - 1.0;
        assert!(change <= MARGIN, "{}: {} instructions, the README says {stated}", count.name, count.most);
        assert!(
            change >= -MARGIN,
            "{}: {} instructions, fewer than the README says: BALLRACE_WRITE=1",
            count.name,
            count.most
        );
    }
}
