-- Times are milliseconds since 1970 by the database's clock, which every statement reads from this view: the view is
-- what differs between engines, the statements are the same.
CREATE VIEW clock AS SELECT CAST(unixepoch('subsec') * 1000 AS INTEGER) AS now_ms;

-- Uploaded meshes and sketches, one row for each content; the geometry itself is a blob named by the id.
CREATE TABLE shapes (
    id         TEXT PRIMARY KEY,
    kind       TEXT NOT NULL,
    name       TEXT,
    body       TEXT NOT NULL,
    created_ms BIGINT NOT NULL
);
CREATE INDEX shapes_newest ON shapes (kind, created_ms, id);

-- Jobs and their leases. `attempt` is the fencing token and only ever grows; `tries` counts the attempts that a job
-- has used up of those it has, which a graceful release gives back.
CREATE TABLE jobs (
    id          TEXT PRIMARY KEY,
    kind        TEXT NOT NULL,
    payload     TEXT NOT NULL,
    dedupe      TEXT,
    priority    BIGINT NOT NULL,
    state       TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempt     BIGINT NOT NULL DEFAULT 0,
    tries       BIGINT NOT NULL DEFAULT 0,
    stage       TEXT,
    fraction    DOUBLE PRECISION NOT NULL DEFAULT 0,
    revision    BIGINT NOT NULL DEFAULT 0,
    error       TEXT,
    result      TEXT,
    lease_ms    BIGINT,
    created_ms  BIGINT NOT NULL,
    started_ms  BIGINT,
    finished_ms BIGINT
);
CREATE INDEX jobs_claim ON jobs (state, priority, created_ms, id);
CREATE INDEX jobs_newest ON jobs (kind, created_ms, id);
CREATE UNIQUE INDEX jobs_unfinished ON jobs (dedupe) WHERE state IN ('queued', 'running');

-- Answers to POSTs that carried an Idempotency-Key.
CREATE TABLE answers (
    key         TEXT NOT NULL,
    route       TEXT NOT NULL,
    fingerprint TEXT NOT NULL,
    status      BIGINT NOT NULL,
    location    TEXT,
    body        BLOB NOT NULL,
    expires_ms  BIGINT NOT NULL,
    PRIMARY KEY (key, route)
);
CREATE INDEX answers_expiry ON answers (expires_ms);
