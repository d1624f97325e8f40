//! The machine code of an image: what is where, what it calls, and what it costs by the manual.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

struct Instruction {
    mnemonic: String,
    operands: String,
    /// Bytes.
    size: u32,
}

/// A disassembly.
pub struct Listing {
    instructions: BTreeMap<u32, Instruction>,
    /// First address of each function and of what stands behind the last.
    functions: BTreeSet<u32>,
}

impl Listing {
    /// By binutils.
    pub fn of(image: &Path) -> Self {
        let output =
            Command::new("arm-none-eabi-objdump").args(["-d", "--section=.text"]).arg(image).output().expect(
                "missing: the cross compiler; type: apt-get install -y --no-install-recommends gcc-arm-none-eabi",
            );
        let mut listing = Self { instructions: BTreeMap::new(), functions: BTreeSet::new() };
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            listing.read(line);
        }
        assert!(!listing.instructions.is_empty(), "a disassembly");
        listing
    }

    /// `00000458 <name>:` or ` 458:\teeb0 2ac0 \tvabs.f32\ts4, s0`.
    fn read(&mut self, line: &str) {
        let Some((address, rest)) = line.split_once([':', ' ']).filter(|_| !line.starts_with(' ')) else {
            let mut cells = line.split('\t');
            let address = cells.next().map(|cell| cell.trim().trim_end_matches(':'));
            let Some(address) = address.and_then(|cell| u32::from_str_radix(cell, 16).ok()) else { return };
            let size = cells.next().map_or(0, |bytes| bytes.split_whitespace().map(|half| half.len() as u32 / 2).sum());
            let mnemonic = cells.next().unwrap_or_default().trim().to_owned();
            let operands = cells.next().unwrap_or_default().to_owned();
            self.instructions.insert(address, Instruction { mnemonic, operands, size });
            return;
        };
        if let (Ok(address), true) = (u32::from_str_radix(address, 16), rest.ends_with(">:")) {
            self.functions.insert(address);
        }
    }

    fn end_of(&self, function: u32) -> u32 {
        let last = self.instructions.last_key_value().map_or(function, |(address, last)| address + last.size);
        self.functions.range(function + 1..).next().copied().unwrap_or(last)
    }

    /// Bytes of the function at `address` and of everything it calls.
    pub fn flash(&self, address: u32) -> u32 {
        let (mut reached, mut open) = (BTreeSet::from([address]), vec![address]);
        while let Some(function) = open.pop() {
            for (_, instruction) in self.instructions.range(function..self.end_of(function)) {
                let target = instruction.target().filter(|target| self.functions.contains(target));
                if let Some(target) = target
                    && reached.insert(target)
                {
                    open.push(target);
                }
            }
        }
        reached.into_iter().map(|function| self.end_of(function) - function).sum()
    }

    /// Cycles along a path of addresses.
    pub fn cycles(&self, path: &[u32]) -> u32 {
        let next = path.iter().skip(1).map(Some).chain([None]);
        path.iter()
            .zip(next)
            .map(|(at, next)| {
                let instruction = &self.instructions[at];
                let jumped = next.is_none_or(|next| *next != at + instruction.size);
                instruction.cycles(jumped)
            })
            .sum()
    }
}

impl Instruction {
    /// Where a branch or call goes.
    fn target(&self) -> Option<u32> {
        let branch =
            self.mnemonic.starts_with('b') && !self.mnemonic.starts_with("bi") && !self.mnemonic.starts_with("bf");
        branch.then(|| u32::from_str_radix(self.operands.split_whitespace().next()?, 16).ok()).flatten()
    }

    /// Cycles of a Cortex-M4 without wait states: ARM, Cortex-M4 Technical Reference Manual r0p1 (DDI 0439),
    /// tables 3-1 and 7-1. A pipeline refill counts 2 of its 1 to 3 cycles, an integer division 12 of its 2 to 12.
    fn cycles(&self, jumped: bool) -> u32 {
        const REFILL: u32 = 2;
        let is = |names: &[&str]| names.iter().any(|name| self.mnemonic.starts_with(name));
        let refill = if jumped { REFILL } else { 0 };
        let double = self.operands.trim_start().starts_with('d');
        let cost = if is(&["vdiv", "vsqrt"]) {
            14
        } else if is(&["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms"]) {
            3
        } else if is(&["vldm", "vstm", "vpush", "vpop", "ldm", "stm", "push", "pop"]) {
            1 + self.registers()
        } else if is(&["vldr", "vstr"]) {
            if double { 3 } else { 2 }
        } else if is(&["vmov"]) {
            if self.operands.matches(',').count() == 3 { 2 } else { 1 }
        } else if is(&["ldrd", "strd"]) {
            3
        } else if is(&["ldr", "str"]) {
            2
        } else if is(&["sdiv", "udiv"]) {
            12
        } else {
            1
        };
        cost + refill
    }

    /// Words in a list such as `{r4, r5, lr}` or `{d8-d15}`.
    fn registers(&self) -> u32 {
        let list = self.operands.split('{').nth(1).unwrap_or_default().trim_end_matches('}');
        let number = |register: &str| register.trim().get(1..).and_then(|digits| digits.parse::<u32>().ok());
        let words = |part: &str| {
            let width = if part.trim().starts_with('d') { 2 } else { 1 };
            let span = part.split_once('-').and_then(|(first, last)| Some(number(last)? - number(first)? + 1));
            width * span.unwrap_or(1)
        };
        list.split(',').map(words).sum()
    }
}
