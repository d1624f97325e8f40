//! Reads `recording.bin` where it is started and prints a checksum a subject; the same program everywhere.
#![cfg_attr(target_os = "none", no_std, no_main)]

use bits::{BYTES, Sample, Subjects, on_counts};

fn run(read: impl FnMut(&mut [u8; BYTES]) -> bool, mut line: impl FnMut(&str, u64)) {
    let Ok(sum) = on_counts() else { return };
    line("on counts", sum);
    along_recording(read, line);
}

/// Goes through the recording: `read` fills a record, or returns false at the end.
#[inline(never)]
fn along_recording(mut read: impl FnMut(&mut [u8; BYTES]) -> bool, line: impl FnMut(&str, u64)) {
    let Ok(mut subjects) = Subjects::try_new() else { return };
    let mut record = [0; BYTES];
    while read(&mut record) {
        subjects.take(&Sample::from_bytes(&record));
    }
    subjects.tell(line);
}

#[cfg(not(target_os = "none"))]
fn main() -> std::io::Result<()> {
    use std::io::Read;
    let mut file = std::io::BufReader::new(std::fs::File::open("recording.bin")?);
    run(|record| file.read_exact(record).is_ok(), |name, sum| println!("{name};{sum:016x}"));
    Ok(())
}

#[cfg(target_os = "none")]
#[cfg_attr(target_arch = "arm", cortex_m_rt::entry)]
#[cfg_attr(target_arch = "riscv32", riscv_rt::entry)]
fn main() -> ! {
    use semihosting::io::Read;
    if let Ok(mut file) = semihosting::fs::File::open(c"recording.bin") {
        run(|record| file.read_exact(record).is_ok(), |name, sum| semihosting::println!("{name};{sum:016x}"));
    }
    semihosting::process::exit(0)
}
