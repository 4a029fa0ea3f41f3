//! `sketchmatch keys`: who may use a server, written to its database.

use std::time::{Duration, SystemTime};

use anyhow::{Context, ensure};
use clap::{Args, Subcommand};

use super::printed;
use crate::config::StoreOptions;
use sketchmatch::access::key_file::time;
use sketchmatch::access::{Key, Scopes, Tenant};
use sketchmatch::store::{KeyRow, Keys};
use sketchmatch::webhooks::secret_as_text;

#[derive(Debug, Args)]
pub struct KeysOptions {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Makes a key and prints it, which cannot be done again.
    Add {
        #[command(flatten)]
        store: StoreOptions,
        /// Whose key it is.
        #[arg(long, env = "SKETCHMATCH_TENANT", default_value_t)]
        tenant: Tenant,
        /// What it may do: read, write, admin, with commas between.
        #[arg(long, env = "SKETCHMATCH_SCOPES", default_value_t)]
        scopes: Scopes,
        /// When it ends: 2027-01-31, 2027-01-31T12:00:00Z, or a time from now such as 90d [default: never].
        #[arg(long, env = "SKETCHMATCH_EXPIRES", value_parser = end)]
        expires: Option<SystemTime>,
        /// What it is called in lists.
        #[arg(long, env = "SKETCHMATCH_NAME")]
        name: Option<String>,
    },
    /// Lists the keys there ever were, without what opens anything.
    List {
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Lets a key open nothing any more, at once.
    Revoke {
        #[command(flatten)]
        store: StoreOptions,
        /// The id of the key, from the list.
        id: String,
    },
    /// Prints what calls that tell of the end of a tenant's jobs are signed with.
    Webhook {
        #[command(flatten)]
        store: StoreOptions,
        /// Whose jobs.
        #[arg(long, env = "SKETCHMATCH_TENANT", default_value_t)]
        tenant: Tenant,
        /// Make a new one first; the old one signs nothing from then on.
        #[arg(long, env = "SKETCHMATCH_RENEW")]
        renew: bool,
    },
    /// Makes a key for what another opens, which ends a while later.
    Rotate {
        #[command(flatten)]
        store: StoreOptions,
        /// The id of the key, from the list.
        id: String,
        /// How long the old key stays good.
        #[arg(long, env = "SKETCHMATCH_OVERLAP", default_value = "24h", value_parser = humantime::parse_duration)]
        overlap: Duration,
    },
}

/// The time a text says, or the one so long from now.
fn end(text: &str) -> Result<SystemTime, String> {
    let from_now = humantime::parse_duration(text).ok().and_then(|rest| SystemTime::now().checked_add(rest));
    from_now.map_or_else(|| time(text), Ok)
}

/// Does what is said of the keys.
///
/// # Errors
/// A store that cannot be opened; an id that no key has.
#[tokio::main(flavor = "current_thread")]
pub async fn run(options: KeysOptions) -> anyhow::Result<()> {
    let keys = Keys::open(&options.store().to_open()).await?;
    let done = carry_out(&keys, options.command).await;
    keys.close().await?;
    done
}

impl KeysOptions {
    fn store(&self) -> &StoreOptions {
        match &self.command {
            Command::Add { store, .. }
            | Command::List { store }
            | Command::Revoke { store, .. }
            | Command::Webhook { store, .. }
            | Command::Rotate { store, .. } => store,
        }
    }
}

async fn carry_out(keys: &Keys, command: Command) -> anyhow::Result<()> {
    match command {
        Command::Add { tenant, scopes, expires, name, .. } => {
            let key = Key::random().context("making a key")?;
            keys.add(&key, (&tenant, &scopes), name.as_deref(), expires).await?;
            printed(key.reveal())
        }
        Command::List { .. } => {
            for key in keys.list().await? {
                printed(&line(&key))?;
            }
            Ok(())
        }
        Command::Revoke { id, .. } => {
            ensure!(keys.revoke(&id).await?, "there is no key {id} that was not revoked before");
            Ok(())
        }
        Command::Webhook { tenant, renew, .. } => printed(&secret_as_text(&keys.webhook_secret(&tenant, renew).await?)),
        Command::Rotate { id, overlap, .. } => {
            let old = keys.key(&id).await?.filter(|key| key.revoked_ms.is_none());
            let old = old.with_context(|| format!("there is no key {id} that was not revoked before"))?;
            let key = Key::random().context("making a key")?;
            keys.add(&key, (&old.tenant, &old.scopes), old.name.as_deref(), None).await?;
            keys.end_after(&id, overlap).await?;
            printed(key.reveal())
        }
    }
}

/// A key as a line of a list: id, tenant, scopes, when it was made and how long it is good, its name.
fn line(key: &KeyRow) -> String {
    let at = |ms: i64| {
        let since = Duration::from_millis(u64::try_from(ms).unwrap_or(0));
        humantime::format_rfc3339_seconds(SystemTime::UNIX_EPOCH + since).to_string()
    };
    let end = match (key.revoked_ms, key.expires_ms) {
        (Some(revoked), _) => format!("revoked {}", at(revoked)),
        (None, Some(expires)) => format!("expires {}", at(expires)),
        (None, None) => "good".to_owned(),
    };
    let fields = [&key.id, key.tenant.as_str(), &key.scopes.to_string(), &at(key.created_ms), &end];
    [fields.join("\t"), key.name.clone().unwrap_or_default()].join("\t").trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_ends_at_a_time_or_after_one() {
        let day = SystemTime::UNIX_EPOCH + Duration::from_secs(86_400);
        assert_eq!(end("1970-01-02"), Ok(day));
        assert_eq!(end("1970-01-02T00:00:00Z"), Ok(day));
        assert!(end("90d").unwrap() > SystemTime::now() + Duration::from_secs(89 * 86_400));
        for text in ["", "soon", "1970-13-01", "-1d"] {
            assert!(end(text).is_err(), "{text}");
        }
    }
}
