// Gives the files of all parts of a plan their names in a store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "parts/done_file.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ExpectedFile {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Calls give(directory of the part, name, store) for all files that the parts have for the
/// version, many at once, and adds them to `expected`. `tell` is called by the calling thread with
/// the number of parts that were begun. Errors: those of `give` and `tell`; kIo.
void give_files_of_parts(const Directory& plan_directory, const std::vector<DoneFile>& parts,
                         std::uint64_t version, const Directory& store,
                         void (*give)(const Directory& from, const std::string& name,
                                      const Directory& to),
                         const std::function<void(std::size_t)>& tell,
                         std::vector<ExpectedFile>& expected);

/// Throws unless the directory has these files with these sizes: another process may have removed
/// some. `what` begins the message. Errors: kBusy.
void check_files(const Directory& directory, const std::vector<ExpectedFile>& expected,
                 const std::string& what);

PLAIT_END_NAMESPACE
