// tools/report_text.h: reports of the commands, as text for people.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "plait/extend/parts.h"
#include "plait/extend/plugins.h"
#include "plait/verify.h"

namespace plait {

/// "rounded to steps of 2e-5: error at most 1e-5 (component), largest found 9.9e-6, ..."
std::string rounding_text(const nlohmann::ordered_json& rounding);

/// "normal: 96 of 96 blocks take no bytes; reading makes them again (normals/position/5)", and a
/// line end.
std::string made_blocks_text(const nlohmann::ordered_json& made);

/// A line for each thing that was found, and what `plait remesh` does about it; empty for a clean
/// mesh.
std::string repair_text(const nlohmann::ordered_json& repairs);

/// "34,834 vertices, 104,496 edges, 69,664 faces; 1 component, no border, Euler number 2".
std::string figures_text(const nlohmann::ordered_json& figures);

/// Two lines, in percent of `diagonal` and in mean edges. `name` says from where to where.
std::string distances_text(std::string_view name, const nlohmann::ordered_json& distances,
                           double diagonal, double mean_edge);

// What this build of plait contains, and what its plug-ins add.

/// {"version", "compiler", "backends": [{"name", "summary", "available", "reason"}], "codecs",
/// "filters", "schemes", "plugins": [{"file", "backends", "codecs", "filters"}]}. `reason` is there
/// if a backend cannot be used on this machine. Backends, codecs and filters are the built-in ones
/// and those of plug-ins; `plugins` tells which plug-in added what.
nlohmann::ordered_json build_report(const Plugins& plugins);
/// The same as lines of text.
std::string build_text(const nlohmann::ordered_json& report);

// Formats damage as text and as JSON, for verify and repair.

nlohmann::ordered_json to_json(const std::vector<DamagedBlock>& blocks);

/// One line for each block, beginning with `word`. If `count` is larger than the number of blocks,
/// another line gives the difference.
std::string to_text(std::string_view word, const std::vector<DamagedBlock>& blocks,
                    std::uint64_t count);

/// Lines about left-over files and other findings that are not damage.
std::string to_text(const std::vector<std::string>& left_over,
                    const std::vector<std::string>& notes);

// What plait join and plait-mpi say of a join.

/// Parts are missing or bad (`plait join --help`).
constexpr int kExitIncomplete = 4;

/// Prints the digest of the store, or what is missing; with `json` an object. Returns the exit
/// status.
int report_join(const JoinResult& joined, const std::filesystem::path& plan,
                const std::filesystem::path& store, double seconds, bool json);
/// The same for parts that are not done, without a join.
int report_incomplete(const std::filesystem::path& plan, const JoinResult& parts, bool json);

}  // namespace plait
