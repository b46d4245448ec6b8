"""What a recording brings: photos, frames, videos, tables. Read strictly, streamed, told clearly."""
