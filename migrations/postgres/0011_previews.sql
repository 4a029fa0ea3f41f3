-- As SQLite's migration of this number.
CREATE TABLE previews (
    job     TEXT COLLATE "C" PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    attempt BIGINT NOT NULL,
    body    BYTEA NOT NULL
);
