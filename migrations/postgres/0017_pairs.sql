-- As SQLite's migration of this number.
ALTER TABLE identity ADD COLUMN paired BIGINT NOT NULL DEFAULT 0;
