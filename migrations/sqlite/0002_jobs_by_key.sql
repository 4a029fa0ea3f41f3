-- Whether a request was carried out under its key is asked of finished jobs too.
CREATE INDEX jobs_by_key ON jobs (dedupe, created_ms) WHERE dedupe IS NOT NULL;
