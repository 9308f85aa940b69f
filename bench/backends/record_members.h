// bench/backends/record_members.h: members of a record that somebody else wrote: each is asked for
// with the type that it must have.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace plait::bench {

/// A record that cannot be believed.
struct BadRecord {
  std::string why;
};

/// The member `name` of an object; null if either is absent. All of these functions throw BadRecord
/// for a value of another type.
const nlohmann::json& member(const nlohmann::json& object, const char* name);
/// Empty if it is absent; cut to kMostText bytes.
std::string text_of(const nlohmann::json& object, const char* name);
/// Finite, and at least 0.
std::optional<double> number_of(const nlohmann::json& object, const char* name);
std::optional<bool> truth_of(const nlohmann::json& object, const char* name);

/// Long text is cut between characters.
std::string cut(std::string text);

}  // namespace plait::bench
