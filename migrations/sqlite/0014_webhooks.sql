-- Whom to tell of the end of a job: gone once told, or given up. Where the job has not ended nothing is due.
CREATE TABLE webhooks (
    job    TEXT PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    url    TEXT NOT NULL,
    tries  BIGINT NOT NULL DEFAULT 0,
    due_ms BIGINT NOT NULL DEFAULT 0
);
