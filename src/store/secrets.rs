use blake3::Hash;
use sqlx::AnyPool;

use super::{Store, StoreError};

impl Store {
    /// The secret of this name, the same for every process on these tables: made where there is none yet.
    ///
    /// # Errors
    /// What the database said; where the system has no chance to offer.
    pub async fn secret(&self, name: &str) -> Result<[u8; 32], StoreError> {
        secret(&self.pool, name).await
    }
}

/// The secret of this name in these tables, made where there is none yet.
pub(super) async fn secret(pool: &AnyPool, name: &str) -> Result<[u8; 32], StoreError> {
    let sql = "SELECT value FROM secrets WHERE name = $1";
    let kept: Option<String> = sqlx::query_scalar(sql).bind(name).fetch_optional(pool).await?;
    let kept = match kept {
        Some(kept) => kept,
        None => {
            let mut new = [0; 32];
            getrandom::fill(&mut new).map_err(|error| StoreError::damaged("the source of chance", error))?;
            let insert = "INSERT INTO secrets (name, value) VALUES ($1, $2) ON CONFLICT (name) DO NOTHING";
            let query = sqlx::query(insert).bind(name).bind(Hash::from_bytes(new).to_hex().to_string());
            query.execute(pool).await?;
            sqlx::query_scalar(sql).bind(name).fetch_one(pool).await?
        }
    };
    let secret = Hash::from_hex(kept).map_err(|error| StoreError::damaged("a secret", error))?;
    Ok(*secret.as_bytes())
}

#[cfg(test)]
mod tests {
    use crate::store::Store;
    use crate::store::testing::{Place, on_every_database};

    #[tokio::test]
    async fn a_secret_stays_what_it_is() {
        on_every_database(asked_twice).await;
    }

    async fn asked_twice(place: Place, store: Store) {
        let (first, other) = (store.secret("one").await.unwrap(), store.secret("other").await.unwrap());
        assert_ne!(first, other);
        drop(store);
        assert_eq!(place.open().await.secret("one").await.unwrap(), first);
    }
}
