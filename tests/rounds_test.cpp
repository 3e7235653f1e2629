#include "catch.h"

#include "bench/rounds.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

using namespace torqued::bench;

namespace
{

Rounds three_rounds()
{
  Rounds rounds;
  // a machine that is ten times slower in one round: ratios 2, 3 and 1.5, medians 30 and 20
  for (const auto& [a, b] : {std::pair(20.0, 10.0), std::pair(300.0, 100.0), std::pair(30.0, 20.0)})
  {
    rounds.add("group", "a", "us", a);
    rounds.add("group", "b", "us", b);
  }
  return rounds;
}

} // namespace

TEST_CASE("rows are reported by medians, and compared by the median of each round's ratio", "[rounds]")
{
  const Rounds rounds = three_rounds();
  REQUIRE(rounds.rows().size() == 2);
  CHECK(rounds.rows()[0].rounds == std::vector{20.0, 300.0, 30.0});
  CHECK(rounds.median("group", "a") == 30.0);
  CHECK(rounds.median("group", "b") == 20.0);
  CHECK(rounds.ratio("group", "a", "b") == 2.0);
  CHECK_THROWS_AS(rounds.median("group", "c"), std::out_of_range);
  CHECK_THROWS_AS(rounds.ratio("group", "a", "c"), std::out_of_range);
  CHECK_THROWS_AS(rounds.ratio("other", "a", "b"), std::out_of_range);

  Rounds even;
  for (const double value : {4.0, 1.0, 2.0, 8.0})
    even.add("group", "a", "us", value);
  CHECK(even.median("group", "a") == 3.0);
}

TEST_CASE("promises are kept or missed, up to their bound, in the table and in the JSON", "[rounds]")
{
  Rounds rounds = three_rounds();
  rounds.promise({"group", "a", "b", 2.0});
  rounds.promise({"group", "a", "b", 2.0});
  rounds.promise({"group", "a", "b", 1.9});
  rounds.promise({"group", "b", "", 20.0, true});
  rounds.promise({"group", "b", "", 20.5, true});
  rounds.promise({"group", "c", "", 1.0});
  REQUIRE(rounds.promises().size() == 5); // said again, it counts once
  CHECK(rounds.found(rounds.promises()[0]) == 2.0);
  CHECK(rounds.found(rounds.promises()[2]) == 20.0);
  CHECK_FALSE(rounds.found(rounds.promises()[4]));

  const std::string table = rounds.table();
  CAPTURE(table);
  CHECK(table.find("2.000 x b: at most 2, kept\n") != std::string::npos);
  CHECK(table.find("2.000 x b: at most 1.9, missed\n") != std::string::npos);
  CHECK(table.find("at least 20, kept\n") != std::string::npos);
  CHECK(table.find("at least 20.5, missed\n") != std::string::npos);

  const auto json = nlohmann::json::parse(rounds.json());
  CHECK(json["rows"][0]["rounds"] == std::vector{20.0, 300.0, 30.0});
  CHECK(json["rows"][0]["median"] == 30.0);
  CHECK(json["promises"][0]["found"] == 2.0);
  CHECK(json["promises"][0]["kept"] == true);
  CHECK(json["promises"][1]["kept"] == false);
  CHECK(json["promises"][3]["at_least"] == 20.5);
  CHECK(json["promises"][4]["found"].is_null());
}
