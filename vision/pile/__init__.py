"""A pile photo → angle of repose: ground, silhouette, sub-pixel surface, base line, least-squares lines."""
