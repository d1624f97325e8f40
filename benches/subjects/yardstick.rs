//! Programs in C that the kernel is measured against, within the same rounds. They report their own processor time, so that what else the
//! machine does between two processes does not count.

use super::{COLUMNS, Subject};
use std::hint::black_box;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// A running C program.
struct Yardstick {
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    _folder: tempfile::TempDir,
}

impl Drop for Yardstick {
    fn drop(&mut self) {
        // It ends when its input does; whether it had ended already does not matter.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// States of a C program, as its input.
pub struct States<'a> {
    /// All that it reads before the numbers of passes.
    pub input: &'a str,
    /// How many states the input has.
    pub count: u32,
    /// Passes over them in one run: many enough that what the pipe costs is below a hundredth.
    pub passes: u32,
}

/// Compiles `benches/yardstick/NAME.c` with `options`, and starts it. Returns `None` without a C compiler.
pub fn subject(row: &str, name: &str, options: &[&str], States { input, count, passes }: States) -> Option<Subject> {
    let mut yardstick = start(name, options, input)?;
    let run = Box::new(move || {
        let told = writeln!(yardstick.orders, "{passes}").and_then(|()| yardstick.orders.flush());
        let mut answer = String::new();
        let read = yardstick.answers.read_line(&mut answer);
        let spent = answer.split(' ').next().and_then(|nanoseconds| nanoseconds.parse().ok());
        black_box((told.is_ok(), read.is_ok(), &answer));
        spent.map(Duration::from_nanos)
    });
    Some(Subject { row: row.to_owned(), column: COLUMNS[0], calls: count * passes, run })
}

fn start(name: &str, options: &[&str], input: &str) -> Option<Yardstick> {
    let folder = tempfile::tempdir().ok()?;
    let program = folder.path().join(name);
    let source = format!("{}/yardstick/{name}.c", env!("CARGO_MANIFEST_DIR"));
    let options = [&["-O3", "-fno-math-errno"], options].concat();
    let built = Command::new("cc").args(options).args([&source, "-o"]).arg(&program).arg("-lm").status();
    if !built.is_ok_and(|status| status.success()) {
        eprintln!("no C compiler: the rows of plain C are left out; type: apt-get install -y gcc");
        return None;
    }
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    let (mut orders, answers) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
    orders.write_all(input.as_bytes()).ok()?;
    Some(Yardstick { child, orders, answers, _folder: folder })
}
