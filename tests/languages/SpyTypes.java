// What lcm-spy would make of a log: it finds types by the class path, and decodes by them.
//   java -cp lcm.jar:torqued.jar SpyTypes.java LOG

import java.io.ByteArrayInputStream;
import java.io.DataInputStream;
import java.io.EOFException;
import java.nio.ByteBuffer;
import java.util.TreeMap;

public class SpyTypes
{
  public static void main(String[] args) throws Exception
  {
    var types = new lcm.spy.LCMTypeDatabase();
    var log = new lcm.logging.Log(args[0], "r");
    var counts = new TreeMap<String, Integer>();
    double sum = 0.0;
    try
    {
      while (true)
      {
        var event = log.readNext();
        Class<?> type = types.getClassByFingerprint(ByteBuffer.wrap(event.data).getLong());
        if (type == null)
          throw new Exception("no type for what is on " + event.channel);
        var input = new DataInputStream(new ByteArrayInputStream(event.data));
        Object message = type.getConstructor(java.io.DataInput.class).newInstance(input);
        counts.merge(event.channel + " " + type.getName(), 1, Integer::sum);
        if (message instanceof torqued.torque_command_t command)
          sum += command.torque[0];
      }
    }
    catch (EOFException end)
    {
    }
    System.out.println(counts + " " + sum);
  }
}
