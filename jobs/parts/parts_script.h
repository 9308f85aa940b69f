// The scripts with which Slurm makes the parts of a plan, and joins them.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/detail/namespace.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Writes a script for sbatch, which asks for the memory and the time of the worst part. An array
/// has at most `longest` tasks. With more parts, the script is given several times, each time with
/// another --offset, as its head says. Errors: those of UnpublishedFile.
void write_sbatch_script(const std::filesystem::path& script, const std::filesystem::path& path,
                         const PartsPlan& plan, std::uint32_t longest);

/// Writes a script that submits the one above, and then itself as a job that joins the parts when
/// they have ended, gives lost parts once more, and runs a command that it was given. Errors: those
/// of UnpublishedFile.
void write_chain_script(const std::filesystem::path& chain, const std::filesystem::path& array,
                        const std::filesystem::path& path, const PartsPlan& plan,
                        std::uint32_t longest);

PLAIT_END_NAMESPACE
