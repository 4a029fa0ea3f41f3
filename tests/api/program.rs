//! The program itself, serving in a process of its own.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread;

use reqwest::Client;
use serde_json::Value;

use crate::server::json_of;

/// What the program writes to standard error.
pub type Log = BufReader<ChildStderr>;

/// The program serving a data directory.
pub struct Program {
    pub child: Child,
    address: String,
}

impl Program {
    /// The program, whose log is read on.
    pub fn start(data: &Path, workers: usize) -> Program {
        Program::with(data, &["--workers", &workers.to_string()])
    }

    /// The program with these options, whose log is read on.
    pub fn with(data: &Path, options: &[&str]) -> Program {
        Program::in_environment(data, options, &[])
    }

    /// The program with these options in an environment that has these variables besides, whose log is read on.
    pub fn in_environment(data: &Path, options: &[&str], variables: &[(&str, &str)]) -> Program {
        let (program, log) = Program::unread(data, options, variables);
        thread::spawn(move || log.lines().map_while(Result::ok).for_each(drop));
        program
    }

    /// The program, and its log from the address on, for the test to read or not.
    pub fn start_unread(data: &Path, workers: usize) -> (Program, Log) {
        Program::unread(data, &["--workers", &workers.to_string()], &[])
    }

    fn unread(data: &Path, options: &[&str], variables: &[(&str, &str)]) -> (Program, Log) {
        let serve = ["serve", "--listen", "127.0.0.1:0", "--log-format", "json"];
        let mut child = Command::new(env!("CARGO_BIN_EXE_sketchmatch"))
            .args(serve)
            .arg("--data-dir")
            .arg(data)
            .args(options)
            // What is freed goes back to the system at once, so that its memory is what is in use, not what the allocator
            // keeps for each thread.
            .env("MALLOC_MMAP_THRESHOLD_", "1000000")
            .envs(variables.iter().copied())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let entries = log.by_ref().lines().map_while(Result::ok);
        let mut addresses = entries.filter_map(|line| {
            let entry: Value = serde_json::from_str(&line).ok()?;
            Some(entry.get("address")?.as_str()?.to_owned())
        });
        let address = format!("http://{}", addresses.next().expect("the log tells the address"));
        drop(addresses);
        (Program { child, address }, log)
    }

    pub fn url(&self, path: &str) -> String {
        format!("{}{path}", self.address)
    }

    /// Host and port.
    pub fn authority(&self) -> &str {
        self.address.trim_start_matches("http://")
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Both fail where the program has ended, which is what is wanted.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// How a match ended, once it has.
pub async fn end(program: &Program, client: &Client, path: &str) -> Value {
    let events = client.get(program.url(&format!("{path}/events"))).send().await.unwrap();
    events.text().await.unwrap();
    json_of(client.get(program.url(path)).send().await.unwrap(), 200).await
}
