-- What the outcome of a running job looks like at first sight, of which attempt.
CREATE TABLE previews (
    job TEXT PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    attempt BIGINT NOT NULL,
    body BLOB NOT NULL
);
