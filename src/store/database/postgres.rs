use std::time::Duration;

use sqlx::any::{AnyConnectOptions, AnyPoolOptions};
use sqlx::postgres::PgListener;
use sqlx::{AnyPool, Executor};
use std::str::FromStr;

use crate::store::{DatabaseUrl, StoreError};

/// Connections of one node; PostgreSQL has 100 for all unless told otherwise.
const CONNECTIONS: u32 = 12;

/// How long a request waits for a connection: less than a client is patient, more than a restart of a small database takes
/// from the last connection to the first.
const PATIENCE: Duration = Duration::from_secs(5);

/// No statement of ours takes as long on tables of any size: what does waits for a lock that nobody gives up. What tables there
/// are already is nothing to be told of.
const SESSION: &str = "SET statement_timeout = '30s'; SET idle_in_transaction_session_timeout = '60s'; \
                       SET client_min_messages = 'warning'";

/// The turn of [`Engine::alone`](super::Engine::alone), held until the transaction ends; the number is ours alone.
pub(super) const TAKE_TURN: &str =
    "SELECT CASE WHEN pg_advisory_xact_lock(7309935468341551219) IS NULL THEN 0 ELSE 1 END";

/// A pool of connections to the database at `url`.
pub(super) async fn connected(url: &str) -> Result<AnyPool, StoreError> {
    let pool = AnyPoolOptions::new()
        .max_connections(CONNECTIONS)
        .acquire_timeout(PATIENCE)
        .after_connect(|connection, _| Box::pin(async move { connection.execute(SESSION).await.map(drop) }))
        .connect_with(AnyConnectOptions::from_str(url)?)
        .await?;
    Ok(pool)
}

/// A change of a job that another node made.
pub struct Told {
    pub job: String,
    /// The state it is in now, as it is stored; something else where it is gone.
    pub state: String,
}

/// Hears of the changes that other nodes make.
pub struct Listener {
    connection: PgListener,
    node: String,
}

impl Listener {
    /// Hears what is told from now on, but for what the node of this name tells itself.
    ///
    /// # Errors
    /// What the database said.
    pub async fn at(url: &DatabaseUrl, node: &str) -> Result<Listener, StoreError> {
        let mut connection = PgListener::connect(&url.called(node)).await?;
        let channel = "SELECT 'sketchmatch_' || current_schema()";
        let channel: String = sqlx::query_scalar(channel).fetch_one(&mut connection).await?;
        connection.listen(&channel).await?;
        Ok(Listener { connection, node: node.to_owned() })
    }

    /// The next change; nothing where changes may have been missed.
    ///
    /// # Errors
    /// What the database said; the listener is then of no use any more.
    pub async fn next(&mut self) -> Result<Option<Told>, StoreError> {
        loop {
            let Some(notice) = self.connection.try_recv().await? else { return Ok(None) };
            let words: Vec<&str> = notice.payload().split(' ').collect();
            if let [node, job, state] = words[..]
                && node != self.node
            {
                return Ok(Some(Told { job: job.to_owned(), state: state.to_owned() }));
            }
        }
    }
}
