//! The program itself, serving in a process of its own.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;

use reqwest::Client;
use serde_json::Value;

use crate::server::json_of;

/// The program serving a data directory.
pub struct Program {
    pub child: Child,
    address: String,
}

impl Program {
    pub fn start(data: &Path, workers: usize) -> Program {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sketchmatch"))
            .args(["serve", "--listen", "127.0.0.1:0", "--log-format", "json", "--workers", &workers.to_string()])
            .arg("--data-dir")
            .arg(data)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        let entry = |line: String| serde_json::from_str::<Value>(&line).ok();
        let address = log.by_ref().filter_map(entry).find_map(|entry| Some(entry.get("address")?.as_str()?.to_owned()));
        let address = format!("http://{}", address.expect("the log tells the address"));
        thread::spawn(move || log.for_each(drop));
        Program { child, address }
    }

    pub fn url(&self, path: &str) -> String {
        format!("{}{path}", self.address)
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
