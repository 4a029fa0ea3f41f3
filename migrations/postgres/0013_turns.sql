-- As SQLite's migration of this number.
ALTER TABLE jobs ADD COLUMN priority BIGINT NOT NULL DEFAULT 0;

ALTER TABLE jobs ADD COLUMN died_ms BIGINT;
ALTER TABLE jobs ADD COLUMN blamed BIGINT NOT NULL DEFAULT 0;
CREATE INDEX jobs_by_death ON jobs (died_ms) WHERE died_ms IS NOT NULL;

CREATE INDEX jobs_by_start ON jobs (tenant, started_ms) WHERE started_ms IS NOT NULL;

CREATE INDEX jobs_running_by_tenant ON jobs (tenant) WHERE state = 'running';
