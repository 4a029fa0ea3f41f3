-- Which shapes a job needs; when it may be tried again; and kinds instead of priorities, for each kind has its share of
-- the threads.
ALTER TABLE jobs ADD COLUMN mesh TEXT;
ALTER TABLE jobs ADD COLUMN sketch TEXT;
ALTER TABLE jobs ADD COLUMN due_ms BIGINT NOT NULL DEFAULT 0;
UPDATE jobs SET mesh = json_extract(payload, '$.mesh'), sketch = json_extract(payload, '$.sketch') WHERE kind = 'match';
UPDATE jobs SET mesh = json_extract(payload, '$.shape')
    WHERE kind = 'spectrum' AND json_extract(payload, '$.kind') = 'mesh';
UPDATE jobs SET sketch = json_extract(payload, '$.shape')
    WHERE kind = 'spectrum' AND json_extract(payload, '$.kind') = 'sketch';
DROP INDEX jobs_claim;
ALTER TABLE jobs DROP COLUMN priority;
CREATE INDEX jobs_claim ON jobs (state, kind, created_ms, id);
CREATE INDEX jobs_by_mesh ON jobs (mesh) WHERE state IN ('queued', 'running');
CREATE INDEX jobs_by_sketch ON jobs (sketch) WHERE state IN ('queued', 'running');

-- What an answer under a key made: the answer is forgotten with it.
ALTER TABLE answers ADD COLUMN resource TEXT;
UPDATE answers SET resource = substr(location, 13) WHERE location LIKE '/v1/matches/%';
UPDATE answers SET resource = substr(location, 12) WHERE location LIKE '/v1/meshes/%';
UPDATE answers SET resource = substr(location, 14) WHERE location LIKE '/v1/sketches/%';
CREATE INDEX answers_by_resource ON answers (resource) WHERE resource IS NOT NULL;

-- Rows that are written to see whether rows can be written.
CREATE TABLE checks (token TEXT PRIMARY KEY);
