// Pages and tables as text and as Markdown.
#include <fmt/format.h>

#include <algorithm>

#include "instrument/figure_text.h"
#include "instrument/page.h"

namespace plait::instrument {
namespace {

constexpr std::size_t kLineWidth = 110;

/// Characters of UTF-8.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
}

/// The headings and the rows.
std::vector<std::vector<std::string>> texts_of(const Table& table) {
  std::vector<std::vector<std::string>> rows(1);
  for (const Table::Column& column : table.columns) rows[0].push_back(column.name);
  for (const Table::Row& row : table.rows)
    for (rows.emplace_back(); const TableCell& cell : row.cells) rows.back().push_back(cell.text);
  return rows;
}

}  // namespace

Table table_with(std::string_view columns, Caption caption) {
  Table table{std::move(caption), {}, {}};
  for (std::size_t at = 0; at <= columns.size();) {
    const std::size_t end = std::min(columns.find('|', at), columns.size());
    const bool number = at < end && columns[at] == '#';
    table.columns.push_back({std::string(columns.substr(at + number, end - at - number)), number});
    at = end + 1;
  }
  return table;
}

std::string to_text(const Table& table) {
  std::vector<std::vector<std::string>> rows = texts_of(table);
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (auto& row : rows) {
    row.resize(widths.size());
    for (std::size_t at = 0; at < row.size(); ++at) {
      row[at] = printable(std::move(row[at]));
      widths[at] = std::max(widths[at], width_of(row[at]));
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t at = 0; at < row.size(); ++at) {
      const std::string space(widths[at] - width_of(row[at]), ' ');
      line +=
          (at == 0 ? "" : "  ") + (table.columns[at].number ? space + row[at] : row[at] + space);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string to_markdown(const Table& table) {
  std::string text;
  for (const auto& row : texts_of(table)) {
    const bool is_first = text.empty();
    text += "|";
    for (const std::string& cell : row) {
      text += ' ';
      for (const char character : cell) {
        if (character == '|') text += '\\';
        text += character;
      }
      text += " |";
    }
    text += "\n";
    if (!is_first) continue;
    text += "|";
    for (const Table::Column& column : table.columns) text += column.number ? "---:|" : "---|";
    text += "\n";
  }
  return text;
}

namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

}  // namespace

std::string Page::markdown(const std::filesystem::path& directory) const {
  namespace fs = std::filesystem;
  const fs::path here = fs::absolute(directory).lexically_normal();
  std::string text = fmt::format("# {}\n", title_);
  for (const Part& part : parts_)
    text += std::visit(
        Overloaded{[](const Section& of) { return fmt::format("## {}\n", of.text); },
                   [](const Command& of) { return fmt::format("    {}\n\n", of.text); },
                   [](const Table& of) { return to_markdown(of) + "\n"; },
                   [&](const Picture& of) {
                     return fmt::format("![{}]({})\n\n", of.caption,
                                        fs::absolute(of.file)
                                            .lexically_normal()
                                            .lexically_relative(here)
                                            .generic_string());
                   },
                   [](const Verdict& of) { return wrapped(of.text, kLineWidth) + "\n"; },
                   [](const Paragraph& of) { return wrapped(of.text, kLineWidth) + "\n"; },
                   [](const List& of) {
                     std::string items;
                     for (const std::string& item : of.items)
                       items += wrapped("- " + item, kLineWidth, "  ");
                     return items + "\n";
                   },
                   [](const auto&) { return std::string(); }},
        part);
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string Page::text() const {
  std::string text = title_.empty() ? "" : title_ + "\n";
  for (const Part& part : parts_)
    text += std::visit(
        Overloaded{
            [](const Section& of) {
              return fmt::format("\n{}\n{:-<{}}\n", of.text, "", of.text.size());
            },
            [](const Command& of) { return fmt::format("    {}\n", of.text); },
            [](const Table& of) { return fmt::format("\n{}\n", to_text(of)); },
            [](const Picture& of) { return fmt::format("{}: {}\n", of.file.native(), of.caption); },
            [](const Verdict& of) { return wrapped(printable(of.text), kLineWidth); },
            [](const Paragraph& of) { return wrapped(printable(of.text), kLineWidth); },
            [](const List& of) {
              std::string items;
              for (const std::string& item : of.items)
                items += wrapped("- " + printable(item), kLineWidth, "  ");
              return items;
            },
            [](const auto&) { return std::string(); }},
        part);
  return text;
}

}  // namespace plait::instrument
