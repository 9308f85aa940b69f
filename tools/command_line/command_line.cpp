#include "command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plait/error.h"

namespace plait {
namespace {

bool is_number(const std::string& word) {
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

Option* Option::required() {
  option_->required();
  return this;
}

Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

Option* Option::default_str(const std::string& text) {
  option_->default_str(text);
  return this;
}

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}

Option* Option::delimiter(char character) {
  option_->delimiter(character);
  return this;
}

Option* Option::allow_extra_args(bool allowed) {
  option_->allow_extra_args(allowed);
  return this;
}

Option* Option::range(int first, int last) {
  option_->check(CLI::Range(first, last));
  return this;
}

Option* Option::range(double first, double last) {
  option_->check(CLI::Range(first, last));
  return this;
}

Option* Option::one_of(std::initializer_list<const char*> values) {
  option_->check(CLI::IsMember(std::vector<std::string>(values.begin(), values.end())));
  return this;
}

Option* Option::excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}

bool Option::given() const { return option_->count() > 0; }

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : owned_(std::make_unique<CLI::App>(description, name)), app_(owned_.get()), name_(name) {}

CommandLine::CommandLine(CLI::App* app, const std::string& name) : app_(app), name_(name) {}

CommandLine::~CommandLine() = default;

CommandLine* CommandLine::add_subcommand(const std::string& name, const std::string& description) {
  commands_.push_back(
      std::unique_ptr<CommandLine>(new CommandLine(app_->add_subcommand(name, description), name)));
  return commands_.back().get();
}

Option* CommandLine::keep(CLI::Option* option) {
  options_.push_back(std::make_unique<Option>(option));
  return options_.back().get();
}

template <class Value>
Option* CommandLine::add_option(const std::string& name, Value& value,
                                const std::string& description) {
  return keep(app_->add_option(name, value, description));
}

template Option* CommandLine::add_option(const std::string&, std::string&, const std::string&);
template Option* CommandLine::add_option(const std::string&, std::filesystem::path&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, int&, const std::string&);
template Option* CommandLine::add_option(const std::string&, unsigned&, const std::string&);
template Option* CommandLine::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option* CommandLine::add_option(const std::string&, double&, const std::string&);
template Option* CommandLine::add_option(const std::string&, std::optional<std::string>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::optional<int>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::optional<double>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::vector<std::string>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::vector<std::filesystem::path>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::vector<std::uint64_t>&,
                                         const std::string&);
template Option* CommandLine::add_option(const std::string&, std::vector<int>&, const std::string&);

Option* CommandLine::add_flag(const std::string& name, bool& value,
                              const std::string& description) {
  return keep(app_->add_flag(name, value, description));
}

Option* CommandLine::add_parsed_option(const std::string& name,
                                       std::function<void(const std::string&)> parse,
                                       const std::string& description) {
  return keep(app_->add_option_function<std::string>(
      name,
      [name, parse = std::move(parse)](const std::string& text) {
        try {
          parse(text);
        } catch (const Error& error) {
          throw CLI::ValidationError(name, error.what());
        }
      },
      description));
}

Option* CommandLine::add_option_with_optional_number(const std::string& name,
                                                     std::function<void(const std::string&)> parse,
                                                     const std::string& description) {
  optional_numbers_.push_back(name);
  return add_parsed_option(name, std::move(parse), description);
}

bool CommandLine::has_optional_number(const std::string& name) const {
  return std::ranges::find(optional_numbers_, name) != optional_numbers_.end() ||
         std::ranges::any_of(commands_, [&](const std::unique_ptr<CommandLine>& command) {
           return command->has_optional_number(name);
         });
}

void CommandLine::footer(const std::string& text) { app_->footer(text); }

void CommandLine::callback(std::function<void()> call) { app_->callback(std::move(call)); }

void CommandLine::version(const std::string& text) { app_->set_version_flag("--version", text); }

void CommandLine::require_subcommand() { app_->require_subcommand(1); }

void CommandLine::help_column(std::size_t column) { app_->get_formatter()->column_width(column); }

CommandLine::Outcome CommandLine::parse(int count, char** words) {
  // CLI11 would take any word behind such an option for its value, the name of a file too.
  std::vector<std::string> given(words, words + count);
  for (std::size_t at = 1; at < given.size() && given[at] != "--"; ++at)
    if (has_optional_number(given[at]) && (at + 1 == given.size() || !is_number(given[at + 1])))
      given[at] += "=0";
  std::vector<const char*> texts;
  for (const std::string& word : given) texts.push_back(word.c_str());
  try {
    app_->parse(count, texts.data());
    return Outcome::kParsed;
  } catch (const CLI::CallForVersion& version) {
    answer_ = std::string(version.what()) + "\n";
  } catch (const CLI::Success&) {
    answer_ = app_->help();
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  return Outcome::kAnswered;
}

std::vector<std::string> CommandLine::subcommand_names() const {
  std::vector<std::string> names;
  for (const auto& command : commands_) names.push_back(command->name());
  return names;
}

std::vector<const CommandLine*> CommandLine::parsed_subcommands() const {
  std::vector<const CommandLine*> parsed;
  for (const auto& command : commands_) {
    if (!command->app_->parsed()) continue;
    parsed.push_back(command.get());
    for (const CommandLine* inner : command->parsed_subcommands()) parsed.push_back(inner);
  }
  return parsed;
}

bool CommandLine::has_option(const std::string& name) const {
  return app_->get_option_no_throw(name) != nullptr;
}

bool CommandLine::given(const std::string& name) const { return app_->count(name) > 0; }

}  // namespace plait
