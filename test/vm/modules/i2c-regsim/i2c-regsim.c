// SPDX-License-Identifier: GPL-2.0-only OR Apache-2.0
// An I2C bus with one chip of 256 registers, for tests in a virtual machine. Unlike the kernel's i2c-stub it answers plain I2C_RDWR
// transfers, and it fails on request. The chip's registers are the file `regs` of the platform device. Writing 0 to its file `plugged` takes the
// bus away as unplugging a USB adapter does: transfers fail, the node in /dev goes, and the adapter when the last program has closed it. Writing 1
// brings it back; that waits for the old one's end, and fails after a minute.
#include <linux/completion.h>
#include <linux/i2c.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/workqueue.h>

static unsigned int addr = 0x68;
module_param(addr, uint, 0644);
MODULE_PARM_DESC(addr, "address of the chip");
static unsigned int nak_every;
module_param(nak_every, uint, 0644);
MODULE_PARM_DESC(nak_every, "every n-th transfer is not acknowledged; 0: none");
static bool stuck;
module_param(stuck, bool, 0644);
MODULE_PARM_DESC(stuck, "transfers time out, as on a bus that a chip holds low");
static unsigned int transfers;
module_param(transfers, uint, 0444);
MODULE_PARM_DESC(transfers, "how many there have been");

static u8 regs[256];
static u8 pointer;
static struct platform_device *device;
static bool plugged;
static DECLARE_COMPLETION(gone);

static int transfer(struct i2c_adapter *adapter, struct i2c_msg *messages, int count)
{
	int i, k;

	if (!READ_ONCE(plugged))
		return -ENODEV;
	transfers++;
	if (stuck)
		return -ETIMEDOUT;
	if (nak_every && transfers % nak_every == 0)
		return -ENXIO;
	for (i = 0; i < count; i++) {
		struct i2c_msg *message = &messages[i];

		if (message->addr != addr)
			return -ENXIO;
		for (k = 0; k < message->len; k++) {
			if (message->flags & I2C_M_RD)
				message->buf[k] = regs[pointer++];
			else if (k == 0)
				pointer = message->buf[0];
			else
				regs[pointer++] = message->buf[k];
		}
	}
	return count;
}

static u32 functionality(struct i2c_adapter *adapter)
{
	return I2C_FUNC_I2C | I2C_FUNC_SMBUS_EMUL;
}

static const struct i2c_algorithm algorithm = {
	.master_xfer = transfer,
	.functionality = functionality,
};

static struct i2c_adapter adapter = {
	.owner = THIS_MODULE,
	.algo = &algorithm,
	.name = "regsim",
};

static ssize_t read_regs(struct file *file, struct kobject *object, struct bin_attribute *attribute, char *buffer,
			 loff_t offset, size_t size)
{
	memcpy(buffer, regs + offset, size);
	return size;
}

static ssize_t write_regs(struct file *file, struct kobject *object, struct bin_attribute *attribute, char *buffer,
			  loff_t offset, size_t size)
{
	memcpy(regs + offset, buffer, size);
	return size;
}

static struct bin_attribute regs_file = {
	.attr = { .name = "regs", .mode = 0644 },
	.size = sizeof(regs),
	.read = read_regs,
	.write = write_regs,
};

static int plug(void)
{
	int result;

	adapter.dev.parent = &device->dev;
	WRITE_ONCE(plugged, true);
	result = i2c_add_adapter(&adapter);
	if (result)
		WRITE_ONCE(plugged, false);
	return result;
}

/* Waits for every program that has the adapter open. */
static void remove_adapter(struct work_struct *work)
{
	i2c_del_adapter(&adapter);
	complete(&gone);
}
static DECLARE_WORK(removal, remove_adapter);

static ssize_t plugged_show(struct device *dev, struct device_attribute *attribute, char *buffer)
{
	return sysfs_emit(buffer, "%d\n", plugged);
}

static ssize_t plugged_store(struct device *dev, struct device_attribute *attribute, const char *buffer, size_t size)
{
	bool wish;
	int result = kstrtobool(buffer, &wish);

	if (result)
		return result;
	if (wish == plugged)
		return size;
	if (!wish) {
		WRITE_ONCE(plugged, false);
		schedule_work(&removal);
		return size;
	}
	if (!wait_for_completion_timeout(&gone, 60 * HZ))
		return -EBUSY;
	result = plug();
	if (result)
		complete(&gone);
	return result ? result : size;
}
static DEVICE_ATTR_RW(plugged);

static int __init begin(void)
{
	int result;

	device = platform_device_register_simple("i2c-regsim", -1, NULL, 0);
	if (IS_ERR(device))
		return PTR_ERR(device);
	result = plug();
	if (result)
		goto no_adapter;
	result = sysfs_create_bin_file(&device->dev.kobj, &regs_file);
	if (result)
		goto no_file;
	result = device_create_file(&device->dev, &dev_attr_plugged);
	if (result)
		goto no_attribute;
	return 0;

no_attribute:
	sysfs_remove_bin_file(&device->dev.kobj, &regs_file);
no_file:
	i2c_del_adapter(&adapter);
no_adapter:
	platform_device_unregister(device);
	return result;
}

static void __exit end(void)
{
	device_remove_file(&device->dev, &dev_attr_plugged);
	sysfs_remove_bin_file(&device->dev.kobj, &regs_file);
	flush_work(&removal);
	if (plugged)
		i2c_del_adapter(&adapter);
	platform_device_unregister(device);
}

module_init(begin);
module_exit(end);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("I2C bus with one chip of 256 registers");
