-- Whether there are blobs that are this database's: from then on a place without its token has not.
ALTER TABLE identity ADD COLUMN paired BIGINT NOT NULL DEFAULT 0;
