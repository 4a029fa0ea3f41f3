use std::time::{Duration, SystemTime};

use blake3::Hash;
use sqlx::any::AnyRow;
use sqlx::{AnyPool, FromRow, Row};

use super::database::Engine;
use super::{Config, Store, StoreError, database, secrets, webhooks};
use crate::access::key_file::milliseconds;
use crate::access::{Grant, Key, Scopes, Tenant};

/// Hexadecimal digits of a key's hash that name the key: too few to find another key by, enough to tell keys apart.
const ID: usize = 16;

/// A key of the database, as people are told of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyRow {
    pub id: String,
    pub tenant: Tenant,
    pub name: Option<String>,
    pub scopes: Scopes,
    /// Milliseconds since 1970 by the database's clock, as all times here.
    pub created_ms: i64,
    pub expires_ms: Option<i64>,
    pub revoked_ms: Option<i64>,
}

impl<'r> FromRow<'r, AnyRow> for KeyRow {
    fn from_row(row: &'r AnyRow) -> Result<KeyRow, sqlx::Error> {
        Ok(KeyRow {
            id: row.try_get("id")?,
            tenant: row.try_get::<&str, _>("tenant")?.parse().map_err(sqlx::Error::decode)?,
            name: row.try_get("name")?,
            scopes: row.try_get::<&str, _>("scopes")?.parse().map_err(sqlx::Error::decode)?,
            created_ms: row.try_get("created_ms")?,
            expires_ms: row.try_get("expires_ms")?,
            revoked_ms: row.try_get("revoked_ms")?,
        })
    }
}

/// The keys in the database.
#[derive(Clone)]
pub struct Keys {
    pool: AnyPool,
    engine: Engine,
}

fn id(hash: &Hash) -> String {
    hash.to_hex()[..ID].to_owned()
}

impl Keys {
    /// The keys of the store of this configuration, also beside a server that has the data directory open. Where the database is
    /// shared, its blobs are not looked at.
    ///
    /// # Errors
    /// As [`Store::open`]; [`StoreError::OtherVersion`] beside a server of a version with other tables.
    pub async fn open(config: &Config) -> Result<Keys, StoreError> {
        if let Some(url) = &config.database_url {
            let pool = database::up_to_date_server(url, "sketchmatch/keys").await?;
            return Ok(Keys { pool, engine: Engine::Postgres });
        }
        match Store::open(config).await {
            // The directory is let go at once, so that a server can be started meanwhile.
            Ok(store) => store.close().await?,
            Err(StoreError::Locked { .. }) => {}
            Err(error) => return Err(error),
        }
        let (pool, engine) = (database::of_file(&config.data_dir.join("sketchmatch.db"), 1).await?, Engine::Sqlite);
        engine.up_to_date(&pool).await?;
        Ok(Keys { pool, engine })
    }

    /// What calls that tell of a tenant's jobs are signed with; a new one in its place where it is to be renewed.
    ///
    /// # Errors
    /// What the database said; where the system has no chance to offer.
    pub async fn webhook_secret(&self, tenant: &Tenant, renewed: bool) -> Result<[u8; 32], StoreError> {
        let name = webhooks::secret_name(tenant);
        if renewed {
            sqlx::query("DELETE FROM secrets WHERE name = $1").bind(&name).execute(&self.pool).await?;
        }
        secrets::secret(&self.pool, &name).await
    }

    /// Ends the use of the database in peace.
    ///
    /// # Errors
    /// What the database said.
    pub async fn close(&self) -> Result<(), StoreError> {
        self.engine.close(&self.pool).await
    }

    /// Keeps the hash of a key and what it opens until `expires`; the key's id.
    ///
    /// # Errors
    /// What the database said.
    pub async fn add(
        &self,
        key: &Key,
        (tenant, scopes): (&Tenant, &Scopes),
        name: Option<&str>,
        expires: Option<SystemTime>,
    ) -> Result<String, StoreError> {
        let hash = key.hash();
        let sql = "INSERT INTO api_keys (id, hash, tenant, name, scopes, created_ms, expires_ms) \
                   SELECT $1, $2, $3, $4, $5, now_ms, $6 FROM clock";
        let query = sqlx::query(sql).bind(id(&hash)).bind(hash.to_hex().to_string()).bind(tenant.as_str()).bind(name);
        query.bind(scopes.to_string()).bind(expires.map(milliseconds)).execute(&self.pool).await?;
        Ok(id(&hash))
    }

    /// All keys there ever were, the oldest first.
    ///
    /// # Errors
    /// What the database said.
    pub async fn list(&self) -> Result<Vec<KeyRow>, StoreError> {
        let sql = "SELECT * FROM api_keys ORDER BY created_ms, id";
        Ok(sqlx::query_as(sql).fetch_all(&self.pool).await?)
    }

    /// The key of this id.
    ///
    /// # Errors
    /// What the database said.
    pub async fn key(&self, id: &str) -> Result<Option<KeyRow>, StoreError> {
        let sql = "SELECT * FROM api_keys WHERE id = $1";
        Ok(sqlx::query_as(sql).bind(id).fetch_optional(&self.pool).await?)
    }

    /// Lets a key open nothing any more; false where it did not before.
    ///
    /// # Errors
    /// What the database said.
    pub async fn revoke(&self, id: &str) -> Result<bool, StoreError> {
        let sql = "UPDATE api_keys SET revoked_ms = (SELECT now_ms FROM clock) WHERE id = $1 AND revoked_ms IS NULL";
        Ok(sqlx::query(sql).bind(id).execute(&self.pool).await?.rows_affected() == 1)
    }

    /// Lets a key open something for as long as this, if it did not end sooner before.
    ///
    /// # Errors
    /// What the database said.
    pub async fn end_after(&self, id: &str, rest: Duration) -> Result<(), StoreError> {
        let sql = "UPDATE api_keys SET expires_ms = (SELECT now_ms FROM clock) + $2 WHERE id = $1 \
                   AND (expires_ms IS NULL OR expires_ms > (SELECT now_ms FROM clock) + $2)";
        let rest_ms = i64::try_from(rest.as_millis()).unwrap_or(i64::MAX);
        sqlx::query(sql).bind(id).bind(rest_ms).execute(&self.pool).await?;
        Ok(())
    }
}

impl Store {
    /// The keys in the database.
    pub fn keys(&self) -> Keys {
        Keys { pool: self.pool.clone(), engine: self.engine }
    }

    /// Whether there ever was a key in the database: a server whose last key was revoked is not open to everybody.
    ///
    /// # Errors
    /// What the database said.
    pub async fn has_keys(&self) -> Result<bool, StoreError> {
        let sql = "SELECT count(*) FROM api_keys";
        Ok(sqlx::query_scalar::<_, i64>(sql).fetch_one(&self.pool).await? > 0)
    }

    /// What the key of this hash opens now, if it is in the database. It is found by its id, which is no secret, and the rest
    /// of its hash compared in constant time.
    ///
    /// # Errors
    /// What the database said.
    pub async fn grant(&self, hash: &Hash) -> Result<Option<Grant>, StoreError> {
        let sql = "SELECT * FROM api_keys WHERE id = $1 AND revoked_ms IS NULL \
                   AND (expires_ms IS NULL OR expires_ms > (SELECT now_ms FROM clock))";
        let Some(row) = sqlx::query(sql).bind(id(hash)).fetch_optional(&self.pool).await? else { return Ok(None) };
        let kept = Hash::from_hex(row.try_get::<&str, _>("hash")?).map_err(sqlx::Error::decode)?;
        let KeyRow { id, tenant, scopes, .. } = KeyRow::from_row(&row)?;
        Ok((kept == *hash).then_some(Grant { tenant, scopes, key: id }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::testing::{Place, fresh, on_every_database, shared_place};

    const ACME: &str = "acme";

    async fn added(keys: &Keys, expires: Option<SystemTime>) -> (Key, String) {
        let (key, tenant) = (Key::random().unwrap(), ACME.parse().unwrap());
        let id = keys.add(&key, (&tenant, &Scopes::default()), Some("laptop"), expires).await.unwrap();
        (key, id)
    }

    #[tokio::test]
    async fn a_key_opens_what_was_said_until_it_is_revoked() {
        on_every_database(revoked).await;
    }

    async fn revoked(place: Place, store: Store) {
        assert!(!store.has_keys().await.unwrap());
        let (key, id) = added(&store.keys(), None).await;
        drop(store);
        let store = place.open().await;
        let grant = Grant { tenant: ACME.parse().unwrap(), scopes: Scopes::default(), key: id.clone() };
        assert_eq!(store.grant(&key.hash()).await.unwrap(), Some(grant));
        assert_eq!(store.grant(&Key::random().unwrap().hash()).await.unwrap(), None);
        assert!(store.keys().revoke(&id).await.unwrap());
        assert!(!store.keys().revoke(&id).await.unwrap() && !store.keys().revoke("none").await.unwrap());
        assert_eq!(store.grant(&key.hash()).await.unwrap(), None);
        // A server whose only key is revoked is still one that asks for keys.
        assert!(store.has_keys().await.unwrap());
    }

    #[tokio::test]
    async fn a_hash_that_only_begins_as_that_of_a_key_opens_nothing() {
        let (_directory, store) = fresh().await;
        let (key, _) = added(&store.keys(), None).await;
        let mut other = *key.hash().as_bytes();
        other[31] ^= 1;
        assert_eq!(store.grant(&other.into()).await.unwrap(), None);
    }

    #[tokio::test]
    async fn a_key_expires() {
        on_every_database(expiring).await;
    }

    async fn expiring(_: Place, store: Store) {
        let (late, _) = added(&store.keys(), Some(SystemTime::UNIX_EPOCH + Duration::from_secs(1))).await;
        assert_eq!(store.grant(&late.hash()).await.unwrap(), None);
        let (key, id) = added(&store.keys(), None).await;
        store.keys().end_after(&id, Duration::from_secs(3600)).await.unwrap();
        assert!(store.grant(&key.hash()).await.unwrap().is_some());
        store.keys().end_after(&id, Duration::ZERO).await.unwrap();
        assert_eq!(store.grant(&key.hash()).await.unwrap(), None);
        let ends = store.keys().key(&id).await.unwrap().unwrap().expires_ms;
        store.keys().end_after(&id, Duration::from_secs(3600)).await.unwrap();
        assert_eq!(store.keys().key(&id).await.unwrap().unwrap().expires_ms, ends);
    }

    #[tokio::test]
    async fn keys_of_a_shared_database_need_no_blobs() {
        let Some(place) = shared_place().await else { return };
        let config = Config { blob_url: None, data_dir: place.path().join("elsewhere"), ..place.config() };
        let (key, _) = added(&Keys::open(&config).await.unwrap(), None).await;
        assert!(!config.data_dir.exists());
        assert!(place.open().await.grant(&key.hash()).await.unwrap().is_some());
    }

    #[tokio::test]
    async fn keys_are_written_beside_a_server_and_before_there_is_one() {
        let directory = tempfile::tempdir().unwrap();
        let config = Config::local(directory.path().join("data"));
        let (first, _) = added(&Keys::open(&config).await.unwrap(), None).await;
        let store = Store::open(&config).await.unwrap();
        let (second, _) = added(&Keys::open(&config).await.unwrap(), None).await;
        for key in [first, second] {
            assert!(store.grant(&key.hash()).await.unwrap().is_some());
        }
        assert_eq!(store.keys().list().await.unwrap().len(), 2);
        assert!(store.has_keys().await.unwrap());
    }
}
