//! SVGs read in a process of their own: the libraries that read them cannot be asked to stop, but the system can.
//!
//! What is known to grow out of proportion is refused before it is read. This is for what is not known: a reader that
//! takes more than its share of time or memory is ended by the system, and with it nothing but the one drawing.

use std::env;
use std::io::{self, BufRead, Write};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};
use serde::{Deserialize, Serialize};

use crate::sketch::{Choice, Config, Imported, Refusal, from_svg};

/// The command of the program that reads an SVG.
pub const COMMAND: &str = "read-svg";

/// Seconds of a processor that a reader may take.
const MOST_SECONDS: u64 = 10;

/// Bytes of address space that a reader may take.
const MOST_BYTES: u64 = 2 << 30;

/// The program that runs now, in whose processes an SVG can be read: the same one also after another was put in its place.
///
/// # Errors
/// When the system does not tell.
pub fn this_program() -> io::Result<PathBuf> {
    let linux = PathBuf::from("/proc/self/exe");
    if linux.exists() { Ok(linux) } else { env::current_exe() }
}

/// What is said to a reader, in a line before the bytes of the drawing.
#[derive(Serialize, Deserialize)]
struct Question {
    wanted: Choice,
    config: Config,
}

/// The sketch in an SVG as [`from_svg`] makes it, read by a process of `program`; refused also where that takes too much.
///
/// # Errors
/// When no process can be started, or what it says cannot be read.
pub fn read(program: &Path, svg: &[u8], wanted: Choice, config: &Config) -> io::Result<Result<Imported, Refusal>> {
    let mut question = serde_json::to_vec(&Question { wanted, config: config.clone() })?;
    question.push(b'\n');
    let mut reader = Command::new(program);
    reader.arg(COMMAND).env_clear().stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut reader = reader.spawn()?;
    if let Some(mut input) = reader.stdin.take() {
        // A reader that has ended takes nothing more; how it ended is asked next.
        let _ = input.write_all(&question).and_then(|()| input.write_all(svg));
    }
    let answer = reader.wait_with_output()?;
    if answer.status.success() {
        return Ok(serde_json::from_slice(&answer.stdout)?);
    }
    Ok(Err(Refusal::plain(if is_of_limits(answer.status) {
        let gibibytes = MOST_BYTES >> 30;
        format!("the SVG takes more than {MOST_SECONDS} s or {gibibytes} GiB of memory to read")
    } else {
        tracing::error!(status = %answer.status, bytes = svg.len(), "the reader of an SVG crashed");
        "the SVG cannot be read: its reader crashed, which is a fault of this program".to_owned()
    })))
}

/// Signals that end a reader at its limits: of a processor, softly and at once, and of memory, without which it gives up.
const OF_LIMITS: [Signal; 3] = [Signal::XCPU, Signal::KILL, Signal::ABORT];

fn is_of_limits(status: ExitStatus) -> bool {
    status.signal().is_some_and(|signal| OF_LIMITS.iter().any(|limit| limit.as_raw() == signal))
}

/// Reads one SVG as [`read`] of another process asks, from `input` to `output`, within limits set here.
///
/// # Errors
/// Where the limits cannot be set, the question cannot be read or the answer not be written.
pub fn serve(mut input: impl BufRead, mut output: impl Write) -> io::Result<()> {
    for (resource, most) in [(Resource::Cpu, MOST_SECONDS), (Resource::As, MOST_BYTES), (Resource::Core, 0)] {
        // Whoever started the program may have set a lower one, which cannot be raised.
        let most = getrlimit(resource).maximum.map_or(most, |set| set.min(most));
        setrlimit(resource, Rlimit { current: Some(most), maximum: Some(most) })?;
    }
    let (mut question, mut svg) = (String::new(), Vec::new());
    input.read_line(&mut question)?;
    input.read_to_end(&mut svg)?;
    let Question { wanted, config } = serde_json::from_str(&question)?;
    let answer: Result<Imported, Refusal> = from_svg(&svg, wanted, &config);
    output.write_all(&serde_json::to_vec(&answer)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_crashed_is_no_drawing_that_takes_much() {
        let wanted = Choice { vertices: 100, figure: 0 };
        let refusal = read(Path::new("/bin/false"), b"<svg/>", wanted, &Config::default()).unwrap().unwrap_err();
        assert!(refusal.to_string().contains("crashed"), "{refusal}");
        let ended_by = |signal: Signal| is_of_limits(ExitStatus::from_raw(signal.as_raw()));
        assert!([Signal::XCPU, Signal::KILL, Signal::ABORT].map(ended_by).iter().all(|&is| is));
        assert!(!ended_by(Signal::SEGV) && !is_of_limits(ExitStatus::from_raw(101 << 8)));
    }
}
