-- How many vertices are computed on, by which memory is weighed: of a surface that was made coarser fewer than its file has.
-- What was uploaded before is weighed by its file.
ALTER TABLE shapes ADD COLUMN matched BIGINT NOT NULL DEFAULT 0;
UPDATE shapes SET matched = vertices;
