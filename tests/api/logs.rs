//! A log that nobody takes holds up nothing.

use std::fs::File;
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::client::client;
use crate::program::Program;

/// More lines than a pipe and what waits beside it hold.
const REQUESTS: usize = 6000;

/// How long a server may take to start or stop on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(60);

async fn answers_and_stops(program: &mut Program) {
    let client = client();
    for _ in 0..REQUESTS {
        assert!(client.get(program.url("/healthz")).send().await.unwrap().status().is_success());
    }
    assert!(ends(&mut program.child));
}

/// Whether a server that is told to stop does so in peace.
fn ends(child: &mut Child) -> bool {
    kill_process(Pid::from_child(child), Signal::TERM).unwrap();
    child.wait().unwrap().success()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_reader_that_stalls_holds_up_nothing() {
    let data = tempfile::tempdir().unwrap();
    let (mut program, _log) = Program::start_unread(data.path(), 1);
    answers_and_stops(&mut program).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_reader_that_has_gone_holds_up_nothing() {
    let data = tempfile::tempdir().unwrap();
    let (mut program, log) = Program::start_unread(data.path(), 1);
    drop(log);
    answers_and_stops(&mut program).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_device_keeps_no_server_from_starting_and_its_losses_are_counted() {
    let data = tempfile::tempdir().unwrap();
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_sketchmatch"))
        .args(["serve", "--listen", &address.to_string(), "--data-dir"])
        .arg(data.path())
        .stderr(Stdio::from(File::options().write(true).open("/dev/full").unwrap()))
        .spawn()
        .unwrap();
    let client = client();
    let since = Instant::now();
    let lost = loop {
        assert!(since.elapsed() < PATIENCE && child.try_wait().unwrap().is_none());
        // Not yet there, or the first report has not been made.
        if let Ok(measures) = client.get(format!("http://{address}/metrics")).send().await {
            let measures = measures.text().await.unwrap();
            let mut lines = measures.lines().filter_map(|line| line.strip_prefix("sketchmatch_log_lines_lost_total "));
            match lines.next().map(|lost| lost.parse::<u64>().unwrap()) {
                None | Some(0) => {}
                Some(lost) => break lost,
            }
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    assert!(lost > 0);
    assert!(ends(&mut child));
}
