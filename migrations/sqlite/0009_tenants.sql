-- Whose something is. What was there before tenants were is the default one's.
ALTER TABLE shapes ADD COLUMN tenant TEXT NOT NULL DEFAULT 'default';
ALTER TABLE jobs ADD COLUMN tenant TEXT NOT NULL DEFAULT 'default';
DROP INDEX shapes_newest;
CREATE INDEX shapes_newest ON shapes (tenant, kind, created_ms, id);
DROP INDEX jobs_newest;
CREATE INDEX jobs_newest ON jobs (tenant, kind, created_ms, id);

-- What all nodes know and nobody else, in hexadecimal digits.
CREATE TABLE secrets (
    name  TEXT PRIMARY KEY,
    value TEXT NOT NULL
);

-- Bytes that are kept of an upload or of a result; 0 of those of earlier versions, of which it is not known.
ALTER TABLE shapes ADD COLUMN bytes BIGINT NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN bytes BIGINT NOT NULL DEFAULT 0;
CREATE INDEX shapes_by_size ON shapes (tenant, bytes);
CREATE INDEX jobs_by_size ON jobs (tenant, bytes) WHERE bytes > 0;

-- Processor time that jobs took, by tenant and by minute since 1970.
CREATE TABLE usage (
    tenant TEXT NOT NULL,
    minute BIGINT NOT NULL,
    cpu_ms BIGINT NOT NULL,
    PRIMARY KEY (tenant, minute)
);

-- When an upload was last asked for, by an upload of the same or by a job; and when it ends by itself, where it does.
ALTER TABLE shapes ADD COLUMN used_ms BIGINT NOT NULL DEFAULT 0;
UPDATE shapes SET used_ms = created_ms;
ALTER TABLE shapes ADD COLUMN expires_ms BIGINT;
CREATE INDEX shapes_by_end ON shapes (expires_ms) WHERE expires_ms IS NOT NULL;
CREATE INDEX shapes_by_use ON shapes (used_ms);
CREATE INDEX jobs_by_end ON jobs (finished_ms) WHERE finished_ms IS NOT NULL;

-- For which shapes a spectrum or a preparation was made: its blob is freed with the last of them.
CREATE TABLE caches (
    blob  TEXT NOT NULL,
    shape TEXT NOT NULL,
    PRIMARY KEY (blob, shape)
);
CREATE INDEX caches_by_shape ON caches (shape);
