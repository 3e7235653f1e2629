#include "daemon_bench.h"

#include "library/torque_client.h"
#include "robot/files/load.h"
#include "robot/robot.h"
#include "wire/codec.h"

#include <atomic>
#include <functional>
#include <limits>
#include <mutex>
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

// whose torques they are, or why there are none, must be readable
bool says(const std::string& text, const std::string& part)
{
  return text.find(part) != std::string::npos;
}

// torques, as numbers to compare
std::vector<double> torques(const Reply& reply)
{
  return expect<torque_command_t>(reply).torque;
}

model_info_t model_of(const std::string& robot)
{
  return model_info(load_robot(robot), 1, 2, "");
}

// A command that a daemon of this robot could have published.
torque_command_t command_of(const model_info_t& model, const desired_state_t& desired)
{
  torque_command_t command{};
  command.utime = desired.utime;
  command.stream_id = desired.stream_id;
  command.model_id = model.model_id;
  command.num_coordinates = model.num_coordinates;
  command.num_joints = model.num_joints;
  command.a.resize(static_cast<std::size_t>(model.num_coordinates));
  command.torque.resize(static_cast<std::size_t>(model.num_joints), 1.0);
  return command;
}

// Somebody on the bus who answers every desired state as the test wants it.
class Impostor
{
public:
  using Make = std::function<torque_command_t(const desired_state_t&)>;

  Impostor()
  {
    bus_.subscribeFunction(channels_.desired, &Impostor::hear, this);
    thread_ = std::thread(
        [this]
        {
          while (!done_)
            bus_.handleTimeout(10);
        });
  }
  ~Impostor()
  {
    done_ = true;
    thread_.join();
  }
  Impostor(const Impostor&) = delete;
  Impostor& operator=(const Impostor&) = delete;

  void name(const model_info_t& model) { bus_.publish(channels_.model, &model); }
  void answer(Make make)
  {
    const std::lock_guard lock(mutex_);
    make_ = std::move(make);
  }

private:
  static void hear(const lcm::ReceiveBuffer* buffer, const std::string&, Impostor* impostor)
  {
    desired_state_t desired;
    const std::lock_guard lock(impostor->mutex_);
    if (!decode(received_bytes(buffer->data, buffer->data_size), desired) || !impostor->make_)
      return;
    const torque_command_t command = impostor->make_(desired);
    impostor->bus_.publish(impostor->channels_.command, &command);
  }

  const Channels channels_;
  lcm::LCM bus_;
  std::mutex mutex_;
  Make make_;
  std::atomic<bool> done_ = false;
  std::thread thread_;
};

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

TEST_CASE("a client hears its own channels, and none that its prefix would fit as a regular expression",
          "[torque_client_process]")
{
  lcm::LCM bus;
  TorqueClient client("", "a.b/");
  model_info_t model = model_of("ck");
  bus.publish(Channels("axb/").model, &model);
  CHECK_FALSE(client.wait_for_model(300ms));
  bus.publish(Channels("a.b/").model, &model);
  CHECK(client.wait_for_model(5s));
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
  else
    expect<torque_command_t>(at_once);
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
  // LCM would look for its own message for ten seconds
  const auto before = TorqueClient::Clock::now();
  std::string why;
  try
  {
    TorqueClient("udpm://239.255.76.67");
  }
  catch (const std::runtime_error& error)
  {
    why = error.what();
  }
  CHECK(why.find("the port is missing") != std::string::npos);
  CHECK(TorqueClient::Clock::now() - before < 5s);
}

TEST_CASE("a client goes by the robot that it heard of first, whatever daemon takes its place",
          "[torque_client_process]")
{
  for (const std::string other : {"rk", "human-subject01", "six-link"})
  {
    CAPTURE(other);
    Pair pair;
    const model_info_t ck = *pair.client.model();
    desired_state_t desired = pair.client.standing();
    expect<torque_command_t>(pair.client.ask(desired, 2s));
    CHECK_FALSE(pair.client.other_model());
    pair.bench.torqued().signal(SIGKILL);
    pair.bench.torqued().wait();
    expect<Silence>(pair.client.ask(desired, 20ms));

    const Bench next{{"--robot", other, "--every-sample"}};
    int rejected = 0;
    for (int i = 0; i < 1000 && rejected < 20; ++i)
    {
      desired = pair.client.standing();
      REQUIRE(desired.num_coordinates == ck.num_coordinates);
      const Reply reply = pair.client.ask(desired, 50ms);
      CHECK_FALSE(std::holds_alternative<torque_command_t>(reply));
      if (const auto* rejection = std::get_if<rejection_t>(&reply))
      {
        ++rejected;
        CHECK((rejection->reason == rejection_t::WRONG_MODEL || rejection->reason == rejection_t::WRONG_SIZE));
      }
    }
    CHECK(rejected == 20);
    CHECK(pair.client.model()->name == "ck");
    CHECK(pair.client.model()->model_id == ck.model_id);
    REQUIRE(pair.client.other_model());
    CHECK(pair.client.other_model()->name == other);

    // a new client goes on with it, once the daemon has forgotten the other stream
    TorqueClient anew;
    REQUIRE(anew.wait_for_model(5s));
    CHECK(anew.model()->name == other);
    bool answered = false;
    for (int i = 0; i < 100 && !answered; ++i)
    {
      desired = anew.standing();
      answered = std::holds_alternative<torque_command_t>(anew.ask(desired, 100ms));
    }
    CHECK(answered);
  }
}

TEST_CASE("a daemon that computes the same robot by other settings is taken over", "[torque_client_process]")
{
  Pair pair;
  const std::int64_t before = pair.client.model()->settings_id;
  pair.bench.torqued().signal(SIGKILL);
  pair.bench.torqued().wait();
  const Bench next{{"--method", "linear-transition"}};
  for (int i = 0; i < 100 && pair.client.model()->settings_id == before; ++i)
    pair.client.handle(50ms);
  CHECK(pair.client.model()->settings_id == next.model->settings_id);
  CHECK(pair.client.model()->instance_id == next.model->instance_id);
  CHECK(pair.client.model()->settings == next.model->settings);
  CHECK_FALSE(pair.client.other_model());
  desired_state_t desired = pair.client.standing();
  expect<torque_command_t>(pair.client.ask(desired, 2s));
}

TEST_CASE("beside a daemon of another robot a client gets its own robot's torques, or none", "[torque_client_process]")
{
  Pair pair;
  const Bench other{{"--robot", "rk", "--every-sample"}};
  int answered = 0, rejected = 0;
  for (int i = 0; i < 200; ++i)
  {
    desired_state_t desired = pair.client.standing();
    const Reply reply = pair.client.ask(desired, 2s);
    if (const auto* command = std::get_if<torque_command_t>(&reply))
    {
      ++answered;
      CHECK(command->model_id == pair.client.model()->model_id);
    }
    else if (const auto* rejection = std::get_if<rejection_t>(&reply))
      rejected += rejection->reason == rejection_t::WRONG_MODEL ? 1 : 0;
  }
  CAPTURE(answered, rejected);
  CHECK(answered + rejected > 100);
  CHECK(pair.client.model()->name == "ck");
  REQUIRE(pair.client.other_model());
  CHECK(pair.client.other_model()->name == "rk");
}

TEST_CASE("torques of another robot, of another size or with a number that is none are discarded",
          "[torque_client_process]")
{
  const model_info_t ck = model_of("ck"), rk = model_of("rk");
  Impostor impostor;
  TorqueClient client;
  desired_state_t desired{};
  const auto ask = [&](Impostor::Make make)
  {
    impostor.answer(std::move(make));
    return client.ask(desired, 5s);
  };
  const auto own = [&](const desired_state_t& asked)
  {
    return command_of(ck, asked);
  };
  const auto discarded = [&](Impostor::Make make) -> std::string
  {
    const Reply reply = ask(std::move(make));
    const auto& found = expect<Discarded>(reply);
    CHECK(found.utime == desired.utime);
    return found.detail;
  };
  CHECK(says(discarded(own), "torques came before any daemon has said which robot it computes"));

  impostor.name(ck);
  REQUIRE(client.wait_for_model(5s));
  desired = client.standing();
  expect<torque_command_t>(ask(own));

  // the same sizes, another robot
  const auto of_rk = [&](const desired_state_t& asked)
  {
    return command_of(rk, asked);
  };
  const std::string of_ck = "; this client goes by ck (model_id " + std::to_string(ck.model_id) + ")";
  CHECK(discarded(of_rk) ==
        "the torques are those of a robot that was not named (model_id " + std::to_string(rk.model_id) + ")" + of_ck);
  impostor.name(rk);
  for (int i = 0; i < 100 && !client.other_model(); ++i)
    client.handle(50ms);
  CHECK(discarded(of_rk) == "the torques are those of rk (model_id " + std::to_string(rk.model_id) + ")" + of_ck);

  for (const std::int32_t more : {-6, -1, 1})
  {
    CAPTURE(more);
    CHECK(says(discarded(
                   [&](const desired_state_t& asked)
                   {
                     torque_command_t command = command_of(ck, asked);
                     command.num_joints += more;
                     command.torque.resize(static_cast<std::size_t>(command.num_joints));
                     return command;
                   }),
               "the command has " + std::to_string(6 + more) + " torques and 7 accelerations; expected 6 and 7"));
    CHECK(says(discarded(
                   [&](const desired_state_t& asked)
                   {
                     torque_command_t command = command_of(ck, asked);
                     command.num_coordinates += more;
                     command.a.resize(static_cast<std::size_t>(command.num_coordinates));
                     return command;
                   }),
               "the command has 6 torques and " + std::to_string(7 + more) + " accelerations; expected 6 and 7"));
  }

  const std::vector<std::pair<std::string, std::function<double&(torque_command_t&)>>> numbers{
      {"torque[0]",
       [](auto& command) -> double&
       {
         return command.torque[0];
       }},
      {"torque[5]",
       [](auto& command) -> double&
       {
         return command.torque[5];
       }},
      {"a[6]",
       [](auto& command) -> double&
       {
         return command.a[6];
       }},
      {"base_a[1]",
       [](auto& command) -> double&
       {
         return command.base_a[1];
       }},
      {"left.fx",
       [](auto& command) -> double&
       {
         return command.left.fx;
       }},
      {"left.fz",
       [](auto& command) -> double&
       {
         return command.left.fz;
       }},
      {"left.moment",
       [](auto& command) -> double&
       {
         return command.left.moment;
       }},
      {"right.cop",
       [](auto& command) -> double&
       {
         return command.right.cop;
       }},
      {"right.friction_ratio",
       [](auto& command) -> double&
       {
         return command.right.friction_ratio;
       }},
      {"zmp",
       [](auto& command) -> double&
       {
         return command.zmp;
       }},
      {"dynamics_residual",
       [](auto& command) -> double&
       {
         return command.dynamics_residual;
       }},
      {"contact_speed",
       [](auto& command) -> double&
       {
         return command.contact_speed;
       }},
      {"contact_residual",
       [](auto& command) -> double&
       {
         return command.contact_residual;
       }},
      {"adjustment",
       [](auto& command) -> double&
       {
         return command.adjustment;
       }}};
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [name, number] : numbers)
    for (const auto& [value, shown] : {std::pair(std::numeric_limits<double>::quiet_NaN(), "nan"),
                                       std::pair(infinity, "inf"), std::pair(-infinity, "-inf")})
    {
      const auto make = [&, &number = number, value = value](const desired_state_t& asked)
      {
        torque_command_t command = command_of(ck, asked);
        number(command) = value;
        return command;
      };
      CHECK(discarded(make) == "a number of the command is not finite: " + name + " is " + shown);
    }

  // the same for what is called back about; and the client goes on
  std::vector<Reply> replies;
  client.on_reply([&](const Reply& reply) { replies.push_back(reply); }, 5s);
  impostor.answer(of_rk);
  client.publish(desired);
  for (int i = 0; i < 100 && replies.empty(); ++i)
    client.handle(50ms);
  REQUIRE(replies.size() == 1);
  CHECK(expect<Discarded>(replies[0]).utime == desired.utime);
  expect<torque_command_t>(ask(own));
}

TEST_CASE("a model message that can be no robot's counts as not heard", "[torque_client_process]")
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(model_info_t&)>> nonsense{
      [](auto& model) { model.name.clear(); },
      [](auto& model)
      {
        model.num_joints = 0;
        model.joint_names.clear();
        model.torque_limits.clear();
        model.rate_limits.clear();
      },
      [](auto& model)
      {
        model.num_joints = model.num_coordinates + 1;
        for (std::int32_t i = 0; i < model.num_joints; ++i)
          model.joint_names.push_back("joint" + std::to_string(i));
        model.joint_names.resize(static_cast<std::size_t>(model.num_joints));
        model.torque_limits.resize(static_cast<std::size_t>(model.num_joints), 1.0);
        model.rate_limits = model.torque_limits;
      },
      [](auto& model) { model.joint_names[1] = model.joint_names[0]; },
      [](auto& model) { model.absolute_names[0].clear(); },
      [](auto& model) { model.relative_names[2] = model.relative_names[1]; },
      [nan](auto& model) { model.gravity = nan; },
      [nan](auto& model) { model.total_mass = nan; },
      [](auto& model) { model.total_mass = 0.0; },
      [nan](auto& model) { model.A[1][2] = nan; },
      [](auto& model) { model.b[1] = std::numeric_limits<double>::infinity(); },
      [nan](auto& model) { model.torque_limits[0] = nan; },
      [](auto& model)
      {
        model.rate_limits[5] = -1.0;
      }};
  Impostor impostor;
  for (std::size_t i = 0; i < nonsense.size(); ++i)
  {
    CAPTURE(i);
    TorqueClient client;
    model_info_t model = model_of("ck");
    nonsense[i](model);
    impostor.name(model);
    impostor.name(model_of("rk"));
    REQUIRE(client.wait_for_model(5s));
    CHECK(client.model()->model_id == model_of("rk").model_id);
    impostor.name(model);
    impostor.name(model_of("compass"));
    for (int k = 0; k < 100 && !client.other_model(); ++k)
      client.handle(50ms);
    REQUIRE(client.other_model());
    CHECK(client.other_model()->name == "compass");
  }
  for (const std::string_view shipped : shipped_robot_names())
  {
    const std::string name(shipped);
    CAPTURE(name);
    TorqueClient client;
    impostor.name(model_of(name));
    REQUIRE(client.wait_for_model(5s));
    CHECK(client.model()->name == name);
  }
}

TEST_CASE("a callback that waits for more replies is told that it must not, and the client goes on",
          "[torque_client_process]")
{
  Pair pair;
  TorqueClient& client = pair.client;
  desired_state_t desired = client.standing();
  const std::vector<std::pair<std::string, std::function<void()>>> calls{{"ask",
                                                                          [&]
                                                                          {
                                                                            client.ask(desired, 1s);
                                                                          }},
                                                                         {"handle",
                                                                          [&]
                                                                          {
                                                                            client.handle(0s);
                                                                          }},
                                                                         {"wait_for_model",
                                                                          [&]
                                                                          {
                                                                            client.wait_for_model(0s);
                                                                          }},
                                                                         {"on_reply", [&]
                                                                          {
                                                                            client.on_reply([](const Reply&) {}, 1s);
                                                                          }}};
  const auto run_until_it_throws = [&](bool by_asking) -> std::string
  {
    try
    {
      for (int i = 0; i < 200; ++i)
        if (by_asking)
          client.ask(desired, 50ms);
        else
          client.handle(50ms);
    }
    catch (const std::logic_error& error)
    {
      return error.what();
    }
    return "";
  };
  for (const auto& [name, call] : calls)
    for (const bool by_asking : {false, true})
      for (const bool silent : {false, true})
      {
        CAPTURE(name, by_asking, silent);
        const std::string expected = "TorqueClient::" + name + "() was called within the callback of on_reply()";
        client.on_reply([&call = call](const Reply&) { call(); }, silent ? 100ms : 2s);
        if (silent)
          pair.bench.torqued().signal(SIGSTOP);
        client.publish(desired);
        CHECK(says(run_until_it_throws(by_asking), expected));
        if (silent)
          pair.bench.torqued().signal(SIGCONT);
        client.on_reply({}, 1s);
        expect<torque_command_t>(client.ask(desired, 5s));
      }
}

} // namespace torque_client_process_test
