-- Whether somebody waits for a job, 0, or it comes after those, 1.
ALTER TABLE jobs ADD COLUMN priority BIGINT NOT NULL DEFAULT 0;

-- When the process of a job last ended before it did, and how often nothing else can have been the cause.
ALTER TABLE jobs ADD COLUMN died_ms BIGINT;
ALTER TABLE jobs ADD COLUMN blamed BIGINT NOT NULL DEFAULT 0;
CREATE INDEX jobs_by_death ON jobs (died_ms) WHERE died_ms IS NOT NULL;

-- When a tenant was last served.
CREATE INDEX jobs_by_start ON jobs (tenant, started_ms) WHERE started_ms IS NOT NULL;

-- How many jobs of a tenant run.
CREATE INDEX jobs_running_by_tenant ON jobs (tenant) WHERE state = 'running';
