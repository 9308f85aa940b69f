// io/made_mark.h: a file by which a directory shows that plait made it and all that plait puts
// there. Names prove nothing: whoever removes what a killed run left looks for the mark.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_NAMESPACE

inline constexpr char kMadeMarkName[] = "plait-made";

/// Errors: kIo, kNoSpace.
void write_made_mark(const Directory& directory);
/// Whether the mark is there, with its content, or alone with a part of it. Errors: kIo.
bool has_made_mark(const Directory& directory);

/// A file by which a store with an unfinished name shows that it is complete and stays: no renaming
/// succeeded.
inline constexpr char kKeptMarkName[] = "plait-kept";

/// Errors: kIo, kNoSpace.
void write_kept_mark(const Directory& directory);

PLAIT_END_NAMESPACE
