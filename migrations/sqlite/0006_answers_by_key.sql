-- An answer is remembered under its key alone: the call is part of what tells one request from another.
CREATE TABLE answers_by_key (
    key         TEXT PRIMARY KEY,
    fingerprint TEXT NOT NULL,
    status      BIGINT NOT NULL,
    location    TEXT,
    body        BLOB NOT NULL,
    expires_ms  BIGINT NOT NULL,
    resource    TEXT
);
-- Of answers that earlier versions kept under one key for several calls the first stays.
INSERT OR IGNORE INTO answers_by_key
    SELECT key, CASE route WHEN '' THEN fingerprint ELSE route || ' ' || fingerprint END, status, location, body,
           expires_ms, resource
    FROM answers ORDER BY expires_ms;
DROP TABLE answers;
ALTER TABLE answers_by_key RENAME TO answers;
CREATE INDEX answers_expiry ON answers (expires_ms);
CREATE INDEX answers_by_resource ON answers (resource) WHERE resource IS NOT NULL;
