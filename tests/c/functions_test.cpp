// The C interface is complete: its header declares what functions.h lists, and functions.h knows
// each public function of the classes that a program reads and writes with.
#include "c/functions.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

using namespace plait::test;

namespace {

using Names = std::set<std::string>;

/// A header without comments and preprocessor lines.
std::string code_of(const std::string& header) {
  std::ifstream file(PLAIT_SOURCE "/" + header);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  REQUIRE(!text.empty());
  text = std::regex_replace(text, std::regex(R"(/\*[^*]*\*+([^/*][^*]*\*+)*/)"), " ");
  text = std::regex_replace(text, std::regex("//[^\n]*"), " ");
  text = std::regex_replace(text, std::regex(R"(#[^\n]*\\\n)"), "#");
  while (text.find("\\\n") != std::string::npos)
    text = std::regex_replace(text, std::regex(R"([^\n]*\\\n)"), "");
  return std::regex_replace(text, std::regex("#[^\n]*"), " ");
}

/// The public functions of a class: the names before the first parenthesis of each declaration.
Names functions_of(const std::string& header, const std::string& name) {
  const std::string code = code_of(header);
  std::smatch head;
  REQUIRE(std::regex_search(code, head, std::regex("\nclass ([A-Z_]+ )?" + name + " \\{")));
  Names found;
  std::string statement;
  int depth = 1;
  for (auto at = head.suffix().first; depth > 0; ++at) {
    depth += (*at == '{') - (*at == '}');
    if (depth == 1 && (*at == ';' || *at == '}')) {
      static const std::regex first_call(R"(^[^(=]*?(~?\w+|operator=)\s*\()");
      std::smatch call;
      if (std::regex_search(statement, call, first_call)) found.insert(name + "::" + call.str(1));
      statement.clear();
    } else if (depth == 1) {
      statement += *at;
      if (statement.ends_with("private:")) break;
    }
  }
  found.erase(name + "::private");
  return found;
}

Names known_of(const std::string& name) {
  Names known;
  const auto add = [&](std::string_view function) {
    if (function.starts_with(name + "::")) known.emplace(function);
  };
  for (const CFunction& function : kCFunctions)
    for (const std::string_view cpp : function.cpp) add(cpp);
  for (const LeftOut& left_out : kLeftOut) add(left_out.cpp);
  return known;
}

}  // namespace

TEST_CASE("CFunctions_HeaderAndList_HaveTheSameFunctions") {
  const std::string code = code_of("c/include/plait.h");
  const std::regex declaration(R"(PLAIT_API[^(;]*?\b(plait_\w+)\s*\()");
  Names declared, listed;
  for (std::sregex_iterator at(code.begin(), code.end(), declaration), end; at != end; ++at)
    declared.insert(at->str(1));
  for (const CFunction& function : kCFunctions) {
    CHECK(function.address != nullptr);
    CHECK(listed.emplace(function.name).second);
  }
  CHECK(declared == listed);
}

TEST_CASE("CFunctions_EachPublicFunctionOfTheClasses_IsPairedOrLeftOutWithAReason") {
  CHECK(functions_of("engine/store/include/plait/store.h", "Store") == known_of("Store"));
  CHECK(functions_of("engine/store/include/plait/notes.h", "StoreNotes") == known_of("StoreNotes"));
  CHECK(functions_of("engine/execution/include/plait/reader.h", "Reader") == known_of("Reader"));
  CHECK(functions_of("engine/execution/include/plait/reader.h", "PatchView") ==
        known_of("PatchView"));
  CHECK(functions_of("engine/execution/include/plait/patch_writer.h", "PatchWriter") ==
        known_of("PatchWriter"));
  for (const LeftOut& left_out : kLeftOut) CHECK(left_out.reason.size() > 10);
}

TEST_CASE("CFunctions_LeftOut_AreNotPaired") {
  for (const LeftOut& left_out : kLeftOut)
    for (const CFunction& function : kCFunctions)
      CHECK(std::ranges::count(function.cpp, left_out.cpp) == 0);
}
