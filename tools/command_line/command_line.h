// tools/command_line/command_line.h: the options of a program or of one of its commands. CLI11 does
// the work behind this interface: its header takes seconds to compile, so one source includes it
// and not each command.
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): that of the library
class App;
class Option;
}  // namespace CLI

namespace plait {

/// Thrown for arguments that do not fit the options. The text names the option.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An option that was added to a CommandLine, and belongs to it. The functions change how the
/// option is parsed or described, and return the same option.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* required();
  /// What --help writes for the value, such as SIZE.
  Option* type_name(const std::string& name);
  Option* default_str(const std::string& text);
  /// --help writes the value that the variable has now.
  Option* capture_default_str();
  /// One argument may have several values with this character between them.
  Option* delimiter(char character);
  /// false: an option takes one value each time that it is given.
  Option* allow_extra_args(bool allowed);
  /// The value must be a number from `first` to `last`.
  Option* range(int first, int last);
  Option* range(double first, double last);
  Option* one_of(std::initializer_list<const char*> values);
  Option* excludes(Option* other);
  /// Whether the arguments had this option.
  bool given() const;

 private:
  CLI::Option* option_;
};

/// The command line of a program, or of a command of a program. Variables that options fill must
/// outlive parse(). Not safe from several threads.
class CommandLine {
 public:
  CommandLine(const std::string& description, const std::string& name);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// A command of this program. The program owns it.
  CommandLine* add_subcommand(const std::string& name, const std::string& description);
  /// An option (--name), or an argument without a name (NAME). `Value` is a std::string,
  /// std::filesystem::path, int, unsigned, std::uint64_t or double; a std::optional of std::string,
  /// int or double; or a std::vector of std::string, std::filesystem::path, int or std::uint64_t.
  template <class Value>
  Option* add_option(const std::string& name, Value& value, const std::string& description);
  Option* add_flag(const std::string& name, bool& value, const std::string& description);
  /// An option whose text goes to `parse`. An Error of `parse` becomes a UsageError that names the
  /// option.
  Option* add_parsed_option(const std::string& name, std::function<void(const std::string&)> parse,
                            const std::string& description);
  /// An option whose number may be left out: then `parse` gets "0". A word that follows and is no
  /// number is the next argument.
  Option* add_option_with_optional_number(const std::string& name,
                                          std::function<void(const std::string&)> parse,
                                          const std::string& description);
  /// The text of --help after the options.
  void footer(const std::string& text);
  /// Called when the arguments of this command have been parsed. May throw UsageError.
  void callback(std::function<void()> call);
  void version(const std::string& text);
  void require_subcommand();
  void help_column(std::size_t column);

  enum class Outcome { kParsed, kAnswered };
  /// kAnswered: the arguments asked for --help or --version, and answer() has the text.
  /// Errors: UsageError.
  Outcome parse(int count, char** words);
  const std::string& answer() const { return answer_; }

  /// The names of all commands of this program.
  std::vector<std::string> subcommand_names() const;
  /// The commands that the arguments named, from the program inwards; after parse(), also after a
  /// parse() that failed.
  std::vector<const CommandLine*> parsed_subcommands() const;
  const std::string& name() const { return name_; }
  /// Whether there is such an option.
  bool has_option(const std::string& name) const;
  /// Whether the arguments had this option.
  bool given(const std::string& name) const;

 private:
  CommandLine(CLI::App* app, const std::string& name);
  Option* keep(CLI::Option* option);
  bool has_optional_number(const std::string& name) const;

  std::unique_ptr<CLI::App> owned_;  ///< only of a program
  CLI::App* app_;
  std::string name_, answer_;
  std::vector<std::string> optional_numbers_;  ///< names of options
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<CommandLine>> commands_;
};

}  // namespace plait
