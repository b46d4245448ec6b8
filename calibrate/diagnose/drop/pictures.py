def with_pictures(again, flown, old, new, tracks, folder, pictures, say):
    return again
