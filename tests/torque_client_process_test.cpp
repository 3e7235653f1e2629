#include "daemon_bench.h"

#include "client/torque_client.h"

#include <stdexcept>
#include <thread>

namespace torque_client_process_test
{

using namespace torqued;
using namespace std::chrono_literals;

namespace
{

// a daemon, and a client that knows its robot
struct Pair
{
  Bench bench{{"--every-sample"}};
  TorqueClient client;

  Pair() { REQUIRE(client.wait_for_model(5s)); }
};

template <typename Kind> const Kind& expect(const Reply& reply)
{
  INFO("reply kind " << reply.index());
  REQUIRE(std::holds_alternative<Kind>(reply));
  return std::get<Kind>(reply);
}

// torques, as numbers to compare
std::vector<double> torques(const Reply& reply)
{
  return expect<torque_command_t>(reply).torque;
}

} // namespace

TEST_CASE("a client is answered with torques, or told why not, in its own stream", "[torque_client_process]")
{
  Pair pair;
  CHECK(pair.client.model()->name == "ck");
  desired_state_t desired = pair.client.standing();
  const Reply first = pair.client.ask(desired, 2s);
  const auto& command = expect<torque_command_t>(first);
  CHECK(command.utime == desired.utime);
  CHECK(command.stream_id == pair.client.stream_id());
  CHECK(command.model_id == pair.client.model()->model_id);
  CHECK(command.torque.size() == 6);
  for (const auto* foot : {&command.left, &command.right})
    CHECK(std::abs(foot->fz - 0.5 * 9.81 * pair.client.model()->total_mass) < 1e-6);

  desired.phase = 1.5;
  const Reply wrong = pair.client.ask(desired, 2s);
  const auto& rejection = expect<rejection_t>(wrong);
  CHECK(rejection.utime == desired.utime);
  CHECK(rejection.detail == "phase is 1.5; expected 0 to 1");

  // stamps rise
  std::int64_t last = desired.utime;
  desired.phase = 0.5;
  for (int i = 0; i < 100; ++i)
  {
    expect<torque_command_t>(pair.client.ask(desired, 2s));
    CHECK(desired.utime > last);
    last = desired.utime;
  }
}

TEST_CASE("a desired state whose vectors are not as long as it says is not sent", "[torque_client_process]")
{
  Pair pair;
  for (std::vector<double> desired_state_t::*numbers : {&desired_state_t::q, &desired_state_t::v, &desired_state_t::a})
    for (const std::size_t size : {0U, 6U, 8U})
    {
      desired_state_t desired = pair.client.standing();
      (desired.*numbers).resize(size);
      CHECK_THROWS_AS(pair.client.ask(desired, 2s), std::invalid_argument);
      CHECK_THROWS_AS(pair.client.publish(desired), std::invalid_argument);
    }
  desired_state_t desired = pair.client.standing();
  desired.num_coordinates = -1;
  CHECK_THROWS_AS(pair.client.publish(desired), std::invalid_argument);
  // and the client goes on; a size that is no robot's is the daemon's to refuse
  desired = pair.client.standing();
  expect<torque_command_t>(pair.client.ask(desired, 2s));
  desired.num_coordinates = 6;
  for (std::vector<double>* numbers : {&desired.q, &desired.v, &desired.a})
    numbers->resize(6);
  CHECK(expect<rejection_t>(pair.client.ask(desired, 2s)).reason == rejection_t::WRONG_SIZE);
}

TEST_CASE("silence is a reply, and what comes later is dropped", "[torque_client_process]")
{
  Pair pair;
  desired_state_t desired = pair.client.standing();
  const std::vector<double> upright = torques(pair.client.ask(desired, 2s));
  pair.bench.torqued().signal(SIGSTOP);
  desired.a[6] = 1.0;
  const auto before = TorqueClient::Clock::now();
  const Reply reply = pair.client.ask(desired, 150ms);
  const auto waited = TorqueClient::Clock::now() - before;
  CHECK(expect<Silence>(reply).utime == desired.utime);
  CHECK(waited >= 150ms);
  CHECK(waited < 2s); // it does wait, but not for the daemon
  pair.bench.torqued().signal(SIGCONT);
  desired.a[6] = 0.0;
  const Reply next = pair.client.ask(desired, 2s);
  CHECK(expect<torque_command_t>(next).utime == desired.utime);
  CHECK(torques(next) == upright); // and not those that the stopped daemon was asked for
}

TEST_CASE("each published desired state is called back about once", "[torque_client_process]")
{
  Pair pair;
  std::vector<Reply> replies;
  pair.client.on_reply([&](const Reply& reply) { replies.push_back(reply); }, 300ms);
  desired_state_t desired = pair.client.standing();
  std::vector<std::int64_t> sent;
  const auto handle_until = [&](std::size_t count)
  {
    for (int i = 0; i < 200 && replies.size() < count; ++i)
      pair.client.handle(50ms);
    CHECK(replies.size() == count);
  };
  for (int i = 0; i < 20; ++i)
  {
    desired.phase = i == 7 ? 2.0 : 0.5;
    pair.client.publish(desired);
    sent.push_back(desired.utime);
  }
  handle_until(20);
  for (std::size_t i = 0; i < 20; ++i)
  {
    CAPTURE(i);
    if (i == 7)
      CHECK(expect<rejection_t>(replies[i]).utime == sent[i]);
    else
      CHECK(expect<torque_command_t>(replies[i]).utime == sent[i]);
  }

  replies.clear();
  desired.phase = 0.5;
  pair.bench.torqued().signal(SIGSTOP);
  pair.client.publish(desired);
  handle_until(1);
  CHECK(expect<Silence>(replies[0]).utime == desired.utime);
  pair.bench.torqued().signal(SIGCONT);
  for (int i = 0; i < 10; ++i)
    pair.client.handle(50ms); // its late answer
  CHECK(replies.size() == 1);

  // those that were published before are called back about while another one is asked
  replies.clear();
  pair.client.publish(desired);
  const std::int64_t published = desired.utime;
  expect<torque_command_t>(pair.client.ask(desired, 2s));
  REQUIRE(replies.size() == 1);
  CHECK(expect<torque_command_t>(replies[0]).utime == published);
}

TEST_CASE("what a callback throws comes out of handle, and the client goes on", "[torque_client_process]")
{
  Pair pair;
  pair.client.on_reply([](const Reply&) { throw std::logic_error("the user's own"); }, 2s);
  desired_state_t desired = pair.client.standing();
  pair.client.publish(desired);
  CHECK_THROWS_AS(
      [&]
      {
        for (int i = 0; i < 100; ++i)
          pair.client.handle(50ms);
      }(),
      std::logic_error);
  expect<torque_command_t>(pair.client.ask(desired, 2s));
}

TEST_CASE("a client that restarts is another stream, answered when the old one has been silent",
          "[torque_client_process]")
{
  Pair pair;
  desired_state_t desired = pair.client.standing();
  expect<torque_command_t>(pair.client.ask(desired, 2s));
  const std::int64_t before = pair.client.stream_id();
  pair.client.restart();
  CHECK(pair.client.stream_id() != before);
  // at once, unless this machine takes longer than the silence of 100 ms that gives the stream away
  const Reply at_once = pair.client.ask(desired, 2s);
  CHECK(desired.stream_id == pair.client.stream_id());
  if (const auto* rejection = std::get_if<rejection_t>(&at_once))
    CHECK(rejection->reason == rejection_t::OTHER_STREAM);
  std::this_thread::sleep_for(150ms);
  expect<torque_command_t>(pair.client.ask(desired, 2s));
}

TEST_CASE("a second client is told that another one is being answered", "[torque_client_process]")
{
  Bench bench;
  TorqueClient first, second;
  REQUIRE(first.wait_for_model(5s));
  REQUIRE(second.wait_for_model(5s));
  CHECK(first.stream_id() != second.stream_id());
  desired_state_t desired = first.standing();
  expect<torque_command_t>(first.ask(desired, 2s));
  desired_state_t other = second.standing();
  CHECK(expect<rejection_t>(second.ask(other, 2s)).reason == 9);
}

TEST_CASE("a client with another prefix hears nothing, and a bus that is none is said", "[torque_client_process]")
{
  Bench bench;
  TorqueClient elsewhere("", "elsewhere/");
  CHECK_FALSE(elsewhere.wait_for_model(100ms));
  CHECK_FALSE(elsewhere.model());
  CHECK_THROWS_AS(TorqueClient("nonsense://"), std::runtime_error);
}

} // namespace torque_client_process_test
