// store/new_output.h: one protocol for all outputs. Each function checks the name, removes what
// killed runs of this machine have left of the output, lets `make` make it under an unfinished
// name, and gives it its name when it is complete. If `make` throws, nothing stays; errors have the
// final path. What is complete stays, whatever happens (io/unpublished.h,
// store/unpublished_store.h).
#pragma once

#include <filesystem>
#include <functional>

#include "plait/options.h"
#include "store/unpublished_store.h"

PLAIT_BEGIN_NAMESPACE

/// `make` makes a store at the path that it gets. Returns the final path in its shortest form.
/// Errors: those of UnpublishedStore and of `make`.
std::filesystem::path make_new_store(const std::filesystem::path& path, Existing existing,
                                     Durability durability, const Warn& warn,
                                     const std::function<void(const std::filesystem::path&)>& make);

/// `make` computes what is to be written, and then takes UnpublishedFile::file(), which begins the
/// file. Errors: those of UnpublishedFile and of `make`.
std::filesystem::path make_new_file(const std::filesystem::path& path, Existing existing,
                                    const Warn& warn,
                                    const std::function<void(UnpublishedFile&)>& make);

/// `make` makes files in the directory that it gets; `remove_content` removes them. Errors:
/// kInvalidArgument if the name is taken; those of `make`; kIo, kNoSpace.
std::filesystem::path make_new_directory(const std::filesystem::path& path, const Warn& warn,
                                         UnpublishedDirectory::RemoveContent remove_content,
                                         const std::function<void(const Directory&)>& make);
/// Throws kInvalidArgument if the name of a new directory is taken: before long work.
void check_new_directory(const std::filesystem::path& path);

PLAIT_END_NAMESPACE
