-- Whose something is. What was there before tenants were is the default one's.
ALTER TABLE shapes ADD COLUMN tenant TEXT NOT NULL DEFAULT 'default';
ALTER TABLE jobs ADD COLUMN tenant TEXT NOT NULL DEFAULT 'default';
DROP INDEX shapes_newest;
CREATE INDEX shapes_newest ON shapes (tenant, kind, created_ms, id);
DROP INDEX jobs_newest;
CREATE INDEX jobs_newest ON jobs (tenant, kind, created_ms, id);
