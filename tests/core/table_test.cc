#include "core/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace powdercal {
namespace {

using testing::ElementsAre;

// The whole message that reading the text gives.
std::string MessageOf(const std::string& text) {
  try {
    Table::ParseCsv(text, "t.csv");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Table, ReadsAndConverts) {
  const Table table = Table::ParseCsv(
      "# measured in March\n"
      "normal_stress [kPa], shear_stress [Pa],friction\n"
      "\n"
      "3, 4.75e4, 0.5\n"
      "  # a comment among the rows, with \"quotes\"\n"
      "+5,-1,.25\n",
      "t.csv");
  EXPECT_EQ(table.file(), "t.csv");
  EXPECT_THAT(table.column_names(), ElementsAre("normal_stress", "shear_stress", "friction"));
  EXPECT_EQ(table.row_count(), 2U);
  EXPECT_THAT(table.Get("normal_stress", "Pa").values, ElementsAre(3000, 5000));
  EXPECT_THAT(table.Get("shear_stress", "kPa").values, ElementsAre(4.75e4, -1));
  EXPECT_THAT(table.Get("friction", "1").values, ElementsAre(0.5, 0.25));
  EXPECT_EQ(table.columns()[0].unit, "kPa");
  EXPECT_EQ(table.columns()[2].unit, "1");
  EXPECT_EQ(table.line_of_row(0), 4);
  EXPECT_EQ(table.line_of_row(1), 6);
  EXPECT_TRUE(table.Has("friction"));
  EXPECT_FALSE(table.Has("Friction"));
}

TEST(Table, WindowsLineEndsByteOrderMarkAndNoLastLineEnd) {
  const Table table = Table::ParseCsv("\xEF\xBB\xBFx [mm],y\r\n\r\n1,2\r\n3,4", "t.csv");
  EXPECT_EQ(table.columns()[0].name, "x");
  EXPECT_THAT(table.Get("x", "m").values, ElementsAre(1e-3, 3e-3));
  EXPECT_EQ(table.line_of_row(1), 4);
}

TEST(Table, QuotedFields) {
  const Table table =
      Table::ParseCsv("\"a, \"\"best\"\"\" , \" b [m/s] \"\n\"1\",\"2\"\n", "t.csv");
  EXPECT_THAT(table.column_names(), ElementsAre("a, \"best\"", "b"));
  EXPECT_THAT(table.Get("b", "m/s").values, ElementsAre(2));
}

TEST(Table, QuotedLineEndsCountAsLines) {
  const Table table = Table::ParseCsv("\"a\nb\",c\n1,2\n", "t.csv");
  EXPECT_EQ(table.columns()[0].name, "a\nb");
  EXPECT_EQ(table.line_of_row(0), 3);
}

TEST(Table, ABadNumberIsFoundByLineAndColumn) {
  EXPECT_EQ(MessageOf("x [m],y\n1,2\n3, four\n"), "t.csv:3:4: y: expected a number (found 'four')");
  EXPECT_EQ(MessageOf("x\n1.5mm\n"), "t.csv:2:1: x: expected a number (found '1.5mm')");
  EXPECT_EQ(MessageOf("x,y\n1, \n"), "t.csv:2:4: y: a number is missing");
  EXPECT_EQ(MessageOf("x\nnan\n"), "t.csv:2:1: x: expected a finite number (found 'nan')");
  EXPECT_EQ(MessageOf("x\n-inf\n"), "t.csv:2:1: x: expected a finite number (found '-inf')");
  EXPECT_EQ(MessageOf("x\n1e999\n"),
            "t.csv:2:1: x: the number is too large or too small (found '1e999')");
  EXPECT_EQ(MessageOf("x [GPa]\n1e300\n"),
            "t.csv:2:1: x: expected a finite number (found '1e300')");
  EXPECT_EQ(MessageOf("x\n+-1\n"), "t.csv:2:1: x: expected a number (found '+-1')");
}

TEST(Table, ColumnsCountCharactersAndNotBytes) {
  EXPECT_EQ(MessageOf("\"µµµ\",y [furlongz]\n1,2\n"), "t.csv:1:7: y: 'furlongz' is not a unit");
}

TEST(Table, AWrongNumberOfFieldsIsFoundByLineAndColumn) {
  EXPECT_EQ(MessageOf("x,y\n1,2\n3\n"), "t.csv:3:2: expected 2 fields, found 1");
  EXPECT_EQ(MessageOf("x,y\n1,2,3\n"), "t.csv:2:5: expected 2 fields, found 3 (found '3')");
  EXPECT_EQ(MessageOf("x\n1,5\n"), "t.csv:2:3: expected 1 field, found 2 (found '5')");
}

TEST(Table, BadHeaders) {
  EXPECT_EQ(MessageOf("x,y,x\n1,2,3\n"), "t.csv:1:5: column 'x' appears twice");
  EXPECT_EQ(MessageOf("x [m],x [mm]\n1,2\n"), "t.csv:1:7: column 'x' appears twice");
  EXPECT_EQ(MessageOf("x [furlongz]\n1\n"), "t.csv:1:1: x: 'furlongz' is not a unit");
  EXPECT_EQ(MessageOf("x [degC]\n1\n"), "t.csv:1:1: x: 'degC' is not a proportional unit");
  EXPECT_EQ(MessageOf("x,\n1,2\n"), "t.csv:1:3: a column without a name");
  EXPECT_EQ(MessageOf("x [m\n1\n"), "t.csv:1:1: expected 'name [unit]' (found 'x [m')");
  EXPECT_EQ(MessageOf("x;y\n1;2\n"),
            "t.csv:1:1: columns must be separated by commas (found 'x;y')");
}

TEST(Table, BadQuotes) {
  EXPECT_EQ(MessageOf("x\n\"1\n"), "t.csv:2:1: this quote is never closed");
  EXPECT_EQ(MessageOf("x,y\n1,\"2\" 3\n"),
            "t.csv:2:7: expected a comma or the end of the line after the closing quote");
  EXPECT_EQ(MessageOf("x\n1\"2\n"), "t.csv:2:2: a quote inside a field without quotes");
}

TEST(Table, AnEmptyTableIsAnError) {
  EXPECT_EQ(MessageOf(""), "t.csv: the file is empty");
  EXPECT_EQ(MessageOf("# only a comment\n \n"), "t.csv: the file is empty");
  EXPECT_EQ(MessageOf("x,y\n"), "t.csv:1:4: the table has no rows");
}

TEST(Table, AnUnknownColumnNamesTheNearest) {
  const Table table = Table::ParseCsv("cohesion [J/m3],friction\n1,2\n", "t.csv");
  try {
    table.Get("cohesoin", "J/m3");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "t.csv: unknown column 'cohesoin' (valid: cohesion, friction); "
                 "did you mean 'cohesion'?");
  }
}

TEST(Table, AWrongDimensionNamesBoth) {
  const Table table = Table::ParseCsv("gap [um]\n80\n", "t.csv");
  try {
    table.Get("gap", "Pa");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "t.csv: gap: expected a unit of pressure or energy density (such as Pa), "
                 "found 'um', a unit of length");
  }
}

TEST(Table, ReadsFiles) {
  const std::string path =
      testing::TempDir() + "powdercal_table_test." + std::to_string(getpid()) + ".csv";
  std::ofstream(path) << "gap [um]\n80\n";
  EXPECT_DOUBLE_EQ(Table::ReadCsv(path).Get("gap", "m").values.at(0), 80e-6);
  std::remove(path.c_str());
  try {
    Table::ReadCsv(path);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              path + ": cannot read the file: No such file or directory");
  }
}

}  // namespace
}  // namespace powdercal
