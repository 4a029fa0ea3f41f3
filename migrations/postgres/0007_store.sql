-- The tables as SQLite has them after its migration of this number; from here on a number means the same in both.
--
-- Times are milliseconds since 1970 by the database's clock, which every statement reads from this view. It goes on within
-- a transaction, so that who waited for a lock does not reckon with the time before.
CREATE VIEW clock AS SELECT CAST(extract(epoch FROM clock_timestamp()) * 1000 AS BIGINT) AS now_ms;

-- Ids are compared by their bytes, as SQLite does, whatever the language of the database.
CREATE TABLE shapes (
    id         TEXT COLLATE "C" PRIMARY KEY,
    kind       TEXT NOT NULL,
    name       TEXT,
    body       TEXT NOT NULL,
    created_ms BIGINT NOT NULL,
    geometry   TEXT NOT NULL DEFAULT '',
    file       TEXT,
    media_type TEXT,
    vertices   BIGINT NOT NULL DEFAULT 0,
    triangles  BIGINT NOT NULL DEFAULT 0
);
CREATE INDEX shapes_newest ON shapes (kind, created_ms, id);

CREATE TABLE jobs (
    id          TEXT COLLATE "C" PRIMARY KEY,
    kind        TEXT NOT NULL,
    payload     TEXT NOT NULL,
    dedupe      TEXT,
    mesh        TEXT COLLATE "C",
    sketch      TEXT COLLATE "C",
    name        TEXT,
    state       TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempt     BIGINT NOT NULL DEFAULT 0,
    tries       BIGINT NOT NULL DEFAULT 0,
    stage       TEXT,
    fraction    DOUBLE PRECISION NOT NULL DEFAULT 0,
    revision    BIGINT NOT NULL DEFAULT 0,
    error       TEXT,
    result      TEXT,
    lease_ms    BIGINT,
    due_ms      BIGINT NOT NULL DEFAULT 0,
    created_ms  BIGINT NOT NULL,
    started_ms  BIGINT,
    finished_ms BIGINT
-- Room beside each row for the beats of a job that runs, which touch no index.
) WITH (fillfactor = 70);
CREATE INDEX jobs_claim ON jobs (kind, created_ms, id) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (id) WHERE state = 'running';
CREATE INDEX jobs_newest ON jobs (kind, created_ms, id);
CREATE UNIQUE INDEX jobs_unfinished ON jobs (dedupe) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_key ON jobs (dedupe, created_ms) WHERE dedupe IS NOT NULL;
CREATE INDEX jobs_by_mesh ON jobs (mesh) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_sketch ON jobs (sketch) WHERE state IN ('queued', 'running');

CREATE TABLE answers (
    key         TEXT PRIMARY KEY,
    fingerprint TEXT NOT NULL,
    status      BIGINT NOT NULL,
    location    TEXT,
    body        BYTEA NOT NULL,
    expires_ms  BIGINT NOT NULL,
    resource    TEXT
);
CREATE INDEX answers_expiry ON answers (expires_ms);
CREATE INDEX answers_by_resource ON answers (resource) WHERE resource IS NOT NULL;

-- Rows that are written to see whether rows can be written.
CREATE TABLE checks (token TEXT PRIMARY KEY);
