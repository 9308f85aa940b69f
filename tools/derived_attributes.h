// Which attributes a command derives, stores or keeps as they are: "ATTRIBUTE=derived" and
// "ATTRIBUTE=stored" among the texts of --compress.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "plait/backend.h"
#include "plait/store.h"

namespace plait {

/// Takes "ATTRIBUTE=derived" out of the texts of --compress, and returns the attributes.
std::set<std::string> take_derived(std::vector<std::string>& texts);
/// The same for "ATTRIBUTE=stored", which every backend can do.
std::set<std::string> take_stored(std::vector<std::string>& texts);
/// Whether one of the texts is for this attribute, alone or among all, at whatever levels.
bool is_compressed_by(const std::vector<std::string>& texts, std::string_view attribute);

/// The pipelines of a copy of `source`: "derived" for the attributes in `derived`, and for those
/// that are derived in the source unless `kept` has them or `texts` name them; `stored` for all
/// others. `source` outlives the result. Errors: kNotFound for an attribute that the source does
/// not have; kNotSupported for one that has no rule.
std::function<std::string(const AttributeSchema&)> with_derived(
    const Store& source, const std::set<std::string>& derived, const std::set<std::string>& kept,
    const std::vector<std::string>& texts, const BackendRegistry& backends,
    std::function<std::string(const AttributeSchema&)> stored);

}  // namespace plait
