-- Bytes of memory a job is reckoned to take, by which jobs are let run beside each other; and how often its process ended before
-- it did: a job of which that is so is a suspect and runs alone.
ALTER TABLE jobs ADD COLUMN memory BIGINT NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN deaths BIGINT NOT NULL DEFAULT 0;
