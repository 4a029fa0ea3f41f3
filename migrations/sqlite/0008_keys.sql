-- Keys that let clients in. Of a key only its hash is kept, in hexadecimal digits; `id` is the first of them and names the key
-- to people. Times are milliseconds since 1970 by the database's clock.
CREATE TABLE api_keys (
    id         TEXT PRIMARY KEY,
    hash       TEXT NOT NULL,
    tenant     TEXT NOT NULL,
    name       TEXT,
    scopes     TEXT NOT NULL,
    created_ms BIGINT NOT NULL,
    expires_ms BIGINT,
    revoked_ms BIGINT
);
