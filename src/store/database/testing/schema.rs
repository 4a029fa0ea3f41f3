//! A place for the tables of one test in a PostgreSQL database.

use std::env;
use std::io::{Write, stderr};
use std::thread;

use sqlx::postgres::PgConnectOptions;
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, Executor, PgConnection};
use tokio::runtime::Builder;
use uuid::Uuid;

/// The database that tests make their schemas in.
const VARIABLE: &str = "SKETCHMATCH_TEST_DATABASE_URL";

/// Where one is looked for unless the variable names it.
const LOCAL: &str = "postgres://postgres@127.0.0.1:5432/postgres";

/// A schema for one test, dropped with all that is in it.
pub struct Schema {
    server: String,
    name: String,
}

impl Schema {
    /// A schema where a PostgreSQL answers; nothing, and a line on standard error, where none does. One that was named has
    /// to answer.
    pub async fn fresh() -> Option<Schema> {
        let named = env::var(VARIABLE).ok();
        let server = named.clone().unwrap_or_else(|| LOCAL.to_owned());
        let name = format!("test_{}", Uuid::now_v7().simple());
        match execute(&server, format!("CREATE SCHEMA {name}")).await {
            Ok(()) => Some(Schema { server, name }),
            Err(error) => {
                assert!(named.is_none(), "{VARIABLE}: {error}");
                let test = thread::current().name().unwrap_or("a test").to_owned();
                // Not by the macro, whose lines are kept from who runs the tests.
                let told = format!("{test}: skipped on PostgreSQL, for none answers at {LOCAL}: {error}\n");
                stderr().write_all(told.as_bytes()).unwrap();
                None
            }
        }
    }

    /// The address of the database, with this schema as the place of tables.
    pub fn url(&self) -> String {
        let separator = if self.server.contains('?') { '&' } else { '?' };
        format!("{}{separator}options[search_path]={}", self.server, self.name)
    }
}

impl Drop for Schema {
    fn drop(&mut self) {
        let (server, sql) = (self.server.clone(), format!("DROP SCHEMA {} CASCADE", self.name));
        // A runtime of its own, for the test's waits for this.
        let dropping = move || {
            let runtime = Builder::new_current_thread().enable_all().build();
            runtime.map(|runtime| runtime.block_on(execute(&server, sql)))
        };
        if !matches!(thread::spawn(dropping).join(), Ok(Ok(Ok(())))) {
            eprintln!("the schema {} is left behind", self.name);
        }
    }
}

async fn execute(server: &str, sql: String) -> Result<(), sqlx::Error> {
    let options: PgConnectOptions = server.parse()?;
    let mut connection: PgConnection = options.connect().await?;
    connection.execute(AssertSqlSafe(sql)).await?;
    connection.close().await
}
